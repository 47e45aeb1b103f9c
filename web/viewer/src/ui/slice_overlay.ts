// Labels in slices: planes of their colors, of the volume itself or of one that lies over it.
import { type VolumeFacts, type Voxels } from "../reader/volume.js";
import { type Cell } from "../decode/cells.js";
import { type Orientation, levelForPixels } from "../view/geometry.js";
import { colorOf } from "../view/label_color.js";
import { type OverlaySlice, type SliceLook, overlaySlice } from "../view/slice_look.js";
import {
  type Plane,
  type PlaneRect,
  composePlane,
  labelPixels,
  planeCells,
  planeRect,
} from "../view/slice_plane.js";
import { type Session } from "./session.js";

/** A plane as it was put together last, and the colors of its labels. */
export interface Painted {
  readonly key: string;
  readonly plane: Plane;
  readonly pixels?: Uint8Array;
}

/** The plane of a rectangle; the one of before where it is the same. */
export function composed(
  before: Painted | undefined,
  session: Session,
  o: Orientation,
  rect: PlaneRect,
): Painted {
  const key = [o.across, o.down, rect.level, rect.slice, ...rect.from, ...rect.size].join();
  if (before?.key === key) return before;
  const peek = (cell: Cell): Voxels | undefined => session.cells.peek(cell);
  return { key, plane: composePlane(session.facts, o, rect, peek) };
}

/** The same with colors; hidden labels and the background are clear. */
export function withColors(
  painted: Painted,
  facts: VolumeFacts,
  hidden: ReadonlySet<number>,
): Painted & { readonly pixels: Uint8Array } {
  if (painted.pixels) return { ...painted, pixels: painted.pixels };
  const pixels = labelPixels(painted.plane, (label) => {
    if (label === 0 || hidden.has(label)) return [0, 0, 0, 0];
    return [...colorOf(facts.labels, label), 255];
  });
  return { ...painted, pixels };
}

/** Where a panel looks. */
export interface LookedAt {
  readonly facts: VolumeFacts;
  readonly orientation: Orientation;
  readonly look: SliceLook;
  readonly slice: number;
  readonly size: readonly [number, number];
}

/** A volume of labels that lies over the one of a panel. */
export class SliceOverlay {
  private painted: Painted | undefined;

  constructor(
    readonly session: Session,
    private readonly owner: string,
    private readonly mostSamples: () => number,
  ) {}

  repaint(): void {
    this.painted = undefined;
  }

  at(of: LookedAt): OverlaySlice | undefined {
    return overlaySlice(of.facts, of.orientation, of.look.map, of.slice, this.session.facts);
  }

  private rect(of: LookedAt, over: OverlaySlice, level: number): PlaneRect {
    const { first, step } = over.map;
    const ends = [first[0] + step[0] * of.size[0], first[1] + step[1] * of.size[1]] as const;
    const shown = {
      lo: [Math.min(first[0], ends[0]), Math.min(first[1], ends[1])] as const,
      hi: [Math.max(first[0], ends[0]), Math.max(first[1], ends[1])] as const,
    };
    return planeRect(this.session.facts.levels, level, over.orientation, over.slice, shown);
  }

  /** The level that has a sample for every pixel. */
  private wantedLevel(of: LookedAt, over: OverlaySlice): number {
    const { levels, geometry } = this.session.facts;
    let level = levelForPixels(levels, geometry, over.orientation, of.look.pixelMm * 1.25);
    while (
      level < levels.length - 1 &&
      Math.max(...this.rect(of, over, level).size) > this.mostSamples()
    ) {
      level += 1;
    }
    return Math.min(level, this.session.preview);
  }

  want(of: LookedAt): void {
    const over = this.at(of);
    const { cells, hasPreview, preview } = this.session;
    const level = over ? this.wantedLevel(of, over) : preview;
    const isWanted = over && hasPreview && level < preview;
    cells.want(
      this.owner,
      isWanted
        ? [{ level, cells: planeCells(over.orientation, this.rect(of, over, level)) }]
        : [],
    );
  }

  /** The finest plane of colors that is here. */
  colors(
    of: LookedAt,
    hidden: ReadonlySet<number>,
  ): { plane: Plane; pixels: Uint8Array; over: OverlaySlice } | undefined {
    const over = this.at(of);
    const { session } = this;
    if (!over || !session.hasPreview) return undefined;
    const level = this.wantedLevel(of, over);
    const finest = this.rect(of, over, level);
    const isHere = session.cells.hasAll({ level, cells: planeCells(over.orientation, finest) });
    const rect = isHere ? finest : this.rect(of, over, session.preview);
    const found = composed(this.painted, session, over.orientation, rect);
    const colored = withColors(found, session.facts, hidden);
    this.painted = colored;
    return { plane: colored.plane, pixels: colored.pixels, over };
  }
}

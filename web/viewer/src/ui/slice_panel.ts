// One slice: what it wants to read, how it is drawn, what is written over it.
import { type Axis, type Vec3 } from "../reader/volume.js";
import { type Step } from "../decode/cell_store.js";
import { type Store } from "../store/state.js";
import {
  type Orientation,
  levelForPixels,
  levelText,
  orientationOf,
  sampleAt,
} from "../view/geometry.js";
import {
  type SliceLook,
  pixelOfVoxel,
  sliceLook,
  voxelAtPixel,
} from "../view/slice_look.js";
import {
  type SlicePainter,
  type SliceTextures,
  type Viewport,
  disposeTextures,
} from "../view/slice_painter.js";
import {
  type PlaneRect,
  planeCells,
  planeRect,
  textureUnit,
} from "../view/slice_plane.js";
import { drawAnnotations } from "./annotations.js";
import { byId } from "./dom.js";
import { type Session } from "./session.js";
import {
  type LookedAt,
  type Painted,
  SliceOverlay,
  composed,
  withColors,
} from "./slice_overlay.js";

/** Samples may be so many pixels long before a finer level is asked for. */
const LONGEST_SAMPLE = 1.25;
/** So many pixels a voxel may fill, and more where a picture is small. */
const LARGEST_VOXEL = 64;
const NAMES = ["x", "y", "z"] as const;

export class SlicePanel {
  readonly element: HTMLElement;
  private readonly lines: HTMLCanvasElement;
  private readonly slider: HTMLInputElement;
  private textures: SliceTextures | undefined;
  private session: Session | undefined;
  private overlay: SliceOverlay | undefined;
  private fine: Painted | undefined;
  private base: Painted | undefined;
  /** Samples along a side of a texture; what the graphics card takes. */
  mostSamples = 4096;

  constructor(
    readonly axis: Axis,
    private readonly store: Store,
    private readonly changed: () => void,
  ) {
    const name = NAMES[axis];
    this.element = byId(`panel-${name}`);
    this.lines = this.element.querySelector("canvas")!;
    this.slider = this.element.querySelector("input")!;
    this.slider.addEventListener("input", () => {
      const at = [...this.store.now.at] as [number, number, number];
      at[axis] = Number(this.slider.value);
      this.store.set({ at });
    });
  }

  open(session: Session | undefined, overlay: Session | undefined): void {
    this.session = session;
    const mostSamples = (): number => this.mostSamples;
    this.overlay = overlay && new SliceOverlay(overlay, `slice-${this.axis}`, mostSamples);
    this.forget();
    if (session) this.slider.max = String(session.facts.levels[0]!.size[this.axis] - 1);
  }

  /** After the graphics context was lost, or cells changed their meaning. */
  forget(): void {
    if (this.textures) disposeTextures(this.textures);
    this.textures = undefined;
    this.repaint();
  }

  /** Puts planes together anew: cells arrived, or labels look different. */
  repaint(): void {
    this.fine = undefined;
    this.base = undefined;
    this.overlay?.repaint();
  }

  get isShown(): boolean {
    return this.element.offsetParent !== null;
  }

  get orientation(): Orientation {
    const g = this.session!.facts.geometry;
    return orientationOf(g, this.axis, !this.store.now.isNeurological);
  }

  private get ratio(): number {
    return window.devicePixelRatio || 1;
  }

  /** In device pixels. */
  get size(): readonly [number, number] {
    const rect = this.element.getBoundingClientRect();
    return [
      Math.max(1, Math.round(rect.width * this.ratio)),
      Math.max(1, Math.round(rect.height * this.ratio)),
    ];
  }

  get look(): SliceLook {
    const view = this.store.now.slices[this.axis];
    return sliceLook(this.session!.facts, this.orientation, view, ...this.size);
  }

  private get slice(): number {
    return this.store.now.at[this.axis];
  }

  /** The level that has a sample for every pixel, as far as the cells' memory goes. */
  private wantedLevel(look: SliceLook): number {
    const { facts, cells } = this.session!;
    let level = levelForPixels(
      facts.levels,
      facts.geometry,
      this.orientation,
      look.pixelMm * LONGEST_SAMPLE,
    );
    const share = cells.budgetBytes / (this.store.now.layout === "four" ? 4 : 2);
    const bytes = facts.type.endsWith("8") ? 1 : facts.type.endsWith("16") ? 2 : 4;
    const isTooLarge = (rect: PlaneRect): boolean =>
      Math.max(...rect.size) > this.mostSamples ||
      planeCells(this.orientation, rect).length * 64 ** 3 * bytes > share;
    while (level < facts.levels.length - 1 && isTooLarge(this.rect(level, look))) level += 1;
    return Math.min(level, this.session!.preview);
  }

  private rect(level: number, look: SliceLook): PlaneRect {
    return planeRect(this.session!.facts.levels, level, this.orientation, this.slice, look);
  }

  /** What this panel wants: one coarser level first, then the one that fits the screen. */
  want(): void {
    const session = this.session;
    if (!session) return;
    const name = `slice-${this.axis}`;
    if (!this.isShown || !session.hasPreview) {
      session.cells.want(name, []);
      return;
    }
    const look = this.look;
    const level = this.wantedLevel(look);
    const steps: Step[] = [];
    for (const k of [level + 1, level]) {
      if (k >= session.preview) continue;
      steps.push({ level: k, cells: planeCells(this.orientation, this.rect(k, look)) });
    }
    session.cells.want(name, steps);
    this.overlay?.want(this.lookedAt(look));
  }

  /** The level that is seen everywhere in this panel. */
  shownLevel(): number {
    const session = this.session!;
    const look = this.look;
    for (let k = this.wantedLevel(look); k < session.preview; ++k) {
      if (
        session.cells.hasAll({
          level: k,
          cells: planeCells(this.orientation, this.rect(k, look)),
        })
      ) {
        return k;
      }
    }
    return session.preview;
  }

  /** Draws into the canvas that all panels share, and the lines above it. */
  draw(painter: SlicePainter, viewport: Viewport, canvasHeight: number): void {
    const session = this.session;
    if (!session || !this.isShown) return;
    const state = this.store.now;
    const look = this.look;
    const o = this.orientation;
    const shown = this.shownLevel();
    const t = (this.textures ??= painter.newTextures());
    const isLabels = session.facts.kind === "labels";
    if (!session.hasPreview) {
      this.drawFirst(session, painter, viewport, canvasHeight);
      return;
    }
    this.base = composed(this.base, session, o, this.rect(shown, look));
    const wanted = this.wantedLevel(look);
    this.fine =
      wanted === shown
        ? this.base
        : composed(this.fine, session, o, this.rect(wanted, look));
    const unit = textureUnit(session.facts);
    t.base.values(this.base.plane, unit);
    t.fine.values(this.fine.plane, unit);
    const colors = this.colorsFor(session, o, look, t);
    painter.draw(
      {
        facts: session.facts,
        orientation: o,
        map: look.map,
        textures: t,
        window: state.window,
        isLabels,
        colors,
      },
      viewport,
      canvasHeight,
    );
    this.slider.value = String(this.slice);
    this.annotate(session, look, shown);
  }

  /** The one coarse slice that is here before all others. */
  private drawFirst(
    session: Session,
    painter: SlicePainter,
    viewport: Viewport,
    canvasHeight: number,
  ): void {
    const first = session.first;
    const o = this.orientation;
    const level = session.facts.levels[session.preview]!;
    if (first?.axis !== this.axis) return;
    if (sampleAt(level, this.axis, this.slice) !== first.plane.slice) return;
    const t = (this.textures ??= painter.newTextures());
    this.base = { key: "first", plane: first.plane };
    const unit = textureUnit(session.facts);
    t.base.values(first.plane, unit);
    t.fine.values(first.plane, unit);
    const look = this.look;
    painter.draw(
      {
        facts: session.facts,
        orientation: o,
        map: look.map,
        textures: t,
        window: this.store.now.window,
        isLabels: session.facts.kind === "labels",
        colors: session.facts.kind === "labels" ? this.colorsFor(session, o, look, t) : undefined,
      },
      viewport,
      canvasHeight,
    );
    this.annotate(session, look, session.preview);
  }

  private colorsFor(
    session: Session,
    o: Orientation,
    look: SliceLook,
    t: SliceTextures,
  ): Parameters<SlicePainter["draw"]>[0]["colors"] {
    if (session.facts.kind === "labels") {
      const colored = withColors(this.base!, session.facts, this.store.now.hiddenLabels);
      this.base = colored;
      t.colors.colors(colored.plane, colored.pixels);
      return { facts: session.facts, orientation: o, map: look.map, share: 1 };
    }
    const found = this.overlay?.colors(this.lookedAt(look), this.store.now.hiddenLabels);
    if (!found) return undefined;
    t.colors.colors(found.plane, found.pixels);
    return {
      facts: this.overlay!.session.facts,
      orientation: found.over.orientation,
      map: found.over.map,
      share: this.store.now.overlayOpacity,
    };
  }

  private lookedAt(look: SliceLook): LookedAt {
    return {
      facts: this.session!.facts,
      orientation: this.orientation,
      look,
      slice: this.slice,
      size: this.size,
    };
  }

  private annotate(session: Session, look: SliceLook, shown: number): void {
    const [width, height] = this.size;
    if (this.lines.width !== width) this.lines.width = width;
    if (this.lines.height !== height) this.lines.height = height;
    const o = this.orientation;
    const fidelity = levelText(session.facts.levels[shown]!);
    const size = session.facts.levels[0]!.size[this.axis];
    const name = session.facts.isPlaceKnown ? o.name : `across ${NAMES[this.axis]}`;
    const title = `${NAMES[this.axis]} ${this.slice} / ${size - 1}`;
    this.element.setAttribute(
      "aria-label",
      `${name} slice, ${title}, ${fidelity} of full resolution`,
    );
    this.slider.setAttribute("aria-label", `${name} slice`);
    drawAnnotations(this.lines.getContext("2d")!, {
      facts: session.facts,
      orientation: o,
      look,
      state: this.store.now,
      slice: this.slice,
      ratio: this.ratio,
      title: session.facts.isPlaceKnown ? `${name} ${title}` : title,
      fidelity: shown === 0 ? "" : `${fidelity} of full resolution`,
    });
  }

  /** The voxel under a place of the page, fractional. */
  voxelAt(clientX: number, clientY: number): Vec3 {
    const rect = this.element.getBoundingClientRect();
    return voxelAtPixel(
      this.orientation,
      this.look.map,
      this.slice,
      (clientX - rect.left) * this.ratio,
      (clientY - rect.top) * this.ratio,
    );
  }

  /** In device pixels from the panel's corner. */
  placeOf(voxel: Vec3): [number, number] {
    return pixelOfVoxel(this.orientation, this.look.map, voxel);
  }

  /** Zooms around a voxel that stays where it is. */
  zoomAt(voxel: Vec3, factor: number): void {
    const state = this.store.now;
    const view = state.slices[this.axis];
    const o = this.orientation;
    const size = this.session!.facts.levels[0]!.size;
    const center = view.center ?? [(size[o.across] - 1) / 2, (size[o.down] - 1) / 2];
    // Of any volume so far that a voxel is seen large.
    const { spacing } = this.session!.facts.geometry;
    const fittingMm = this.look.pixelMm * view.zoom;
    const most = Math.max(200, (LARGEST_VOXEL * fittingMm) / Math.min(...spacing));
    const zoom = Math.max(0.25, Math.min(most, view.zoom * factor));
    const share = 1 - view.zoom / zoom;
    this.place(
      [
        center[0] + (voxel[o.across] - center[0]) * share,
        center[1] + (voxel[o.down] - center[1]) * share,
      ],
      zoom,
    );
  }

  /** Moves what is shown by so many device pixels. */
  pan(dx: number, dy: number): void {
    const view = this.store.now.slices[this.axis];
    const o = this.orientation;
    const size = this.session!.facts.levels[0]!.size;
    const center = view.center ?? [(size[o.across] - 1) / 2, (size[o.down] - 1) / 2];
    const step = this.look.map.step;
    this.place([center[0] - dx * step[0], center[1] - dy * step[1]], view.zoom);
  }

  private place(center: readonly [number, number], zoom: number): void {
    const slices = { ...this.store.now.slices, [this.axis]: { center, zoom } };
    this.store.set({ slices });
    this.changed();
  }

  /** A picture of the lines over the slice. */
  get overlayCanvas(): HTMLCanvasElement {
    return this.lines;
  }
}

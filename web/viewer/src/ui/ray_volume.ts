// One volume of the 3-D view: which pages of it are wanted, and its atlas on the graphics card.
import { type BlockRanges, AXES, type Box } from "../reader/volume.js";
import { SlotTable, atlasShape, pageGrid } from "../view/atlas.js";
import { type Gl } from "../view/gl.js";
import { LabelIndex } from "../view/label_index.js";
import { PageAtlas, atlasFormat } from "../view/page_atlas.js";
import { MOST_BLOCKS, RayScene, type Visible, withoutGaps } from "../view/ray_scene.js";
import { type Session } from "./session.js";

/** Samples of the 3-D view may be so many pixels long. */
const LONGEST_SAMPLE = 2;

export class RayVolume {
  readonly index: LabelIndex | undefined;
  private scene: RayScene | undefined;
  private held: PageAtlas | undefined;
  private gl: Gl | undefined;
  private ranges: BlockRanges | undefined;
  private hasAsked = false;
  private tableIsStale = true;

  /** changed  what can be seen is known better: plan anew. */
  constructor(
    readonly session: Session,
    private readonly mostBytes: number,
    private readonly changed: () => void,
  ) {
    this.index = session.facts.kind === "labels" ? new LabelIndex() : undefined;
  }

  get isReady(): boolean {
    return this.session.hasPreview;
  }

  /** The textures of a context; undefined before anything can be shown. */
  atlas(gl: Gl): PageAtlas | undefined {
    const { session } = this;
    if (!this.isReady) return undefined;
    if (!this.hasAsked) {
      this.hasAsked = true;
      void this.readRanges();
    }
    if (this.held && this.gl === gl) return this.held;
    const { facts, preview } = session;
    let pages = 0;
    for (let k = 0; k <= preview; ++k) {
      const grid = pageGrid(facts.levels[k]!);
      pages += grid[0] * grid[1] * grid[2];
    }
    const longest = gl.getParameter(gl.MAX_3D_TEXTURE_SIZE) as number;
    const shape = atlasShape(pages, atlasFormat(gl, facts).bytes, this.mostBytes, longest);
    this.gl = gl;
    this.scene = new RayScene(facts, session.cells, new SlotTable(shape), preview, this.ranges);
    this.held = new PageAtlas(gl, facts, shape, preview, this.index);
    this.tableIsStale = true;
    return this.held;
  }

  private async readRanges(): Promise<void> {
    const { session } = this;
    const { size } = session.facts.levels[0]!;
    if ((size[0] * size[1] * size[2]) / 64 ** 3 > MOST_BLOCKS) return;
    try {
      const { facts, preview, cells, volume } = session;
      this.ranges = withoutGaps(await volume.ranges(), facts, preview, (c) => cells.peek(c));
      this.scene?.setRanges(this.ranges);
      this.changed();
    } catch {
      // Without them nothing is skipped before it is read; a failing server is told of by cells.
    }
  }

  /** The coarsest level whose samples are at most LONGEST_SAMPLE pixels long. */
  private wantedLevel(pixelMm: number): number {
    const { facts, preview } = this.session;
    for (let k = preview; k > 0; --k) {
      const f = facts.levels[k]!.factor;
      const longest = Math.max(...AXES.map((a) => f[a] * facts.geometry.spacing[a]));
      if (longest <= LONGEST_SAMPLE * pixelMm) return k;
    }
    return 0;
  }

  /** Asks for pages of a picture with such pixels; for none where nothing is shown. */
  want(picture: { pixelMm: number; visible: Visible; clip: Box } | undefined): void {
    const { scene, session } = this;
    if (!picture || !scene || !session.hasPreview) {
      session.cells.want("3d", []);
      return;
    }
    const level = this.wantedLevel(picture.pixelMm);
    session.cells.want("3d", scene.plan(level, picture.visible, picture.clip));
    this.tableIsStale = true;
  }

  /** Uploads pages that are here, so many at most; whether the picture changes, or more come. */
  load(most: number): { isMore: boolean; isChanged: boolean } {
    const { scene, held } = this;
    if (!scene || !held) return { isMore: false, isChanged: false };
    const isMore = scene.load(held, most);
    const isChanged = isMore || this.tableIsStale;
    if (isChanged) held.setTable({ level: scene.level, grid: scene.grid, ...scene.table() });
    this.tableIsStale = false;
    return { isMore, isChanged };
  }

  /** The finest level of which all that is wanted is here; and whether no finer one is wanted. */
  shown(): { level: number; isFinest: boolean } {
    const level = this.scene?.shownLevel() ?? this.session.preview;
    return { level, isFinest: level === (this.scene?.level ?? -1) };
  }

  /** The textures are given back, or were lost with their context. */
  forget(): void {
    this.held?.dispose();
    this.held = undefined;
    this.scene = undefined;
    this.gl = undefined;
  }

  close(): void {
    this.forget();
    this.session.cells.want("3d", []);
  }
}

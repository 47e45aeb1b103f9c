// The 3-D view: what it wants to read, when rays are traced anew, and how finely.
import { type BlockRanges, type Box, type Vec3 } from "../reader/volume.js";
import { type Store } from "../store/state.js";
import { SlotTable, atlasShape, pageGrid } from "../view/atlas.js";
import { raysOf, sideLetter, viewAxes } from "../view/camera.js";
import { levelText } from "../view/geometry.js";
import { type Gl, texelFormat } from "../view/gl.js";
import { colorOf } from "../view/label_color.js";
import { BAND_COUNT, type RayLook, RayPainter } from "../view/ray_painter.js";
import { MOST_BLOCKS, RayScene, type Visible } from "../view/ray_scene.js";
import { type Viewport } from "../view/slice_painter.js";
import { largestOpacity, transferSpan, transferTable } from "../view/transfer.js";
import { byId } from "./dom.js";
import { type Session } from "./session.js";

const MOST_ATLAS_BYTES = 96 << 20;
const PAGES_PER_FRAME = 48;
const COLORS = 1024;
/** Samples of the 3-D view may be so many pixels long. */
const LONGEST_SAMPLE = 2;

export class RayPanel {
  readonly element = byId("panel-3d");
  private readonly lines = this.element.querySelector("canvas")!;
  private session: Session | undefined;
  private scene: RayScene | undefined;
  private painter: RayPainter | undefined;
  private gl: Gl | undefined;
  private ranges: BlockRanges | undefined;
  private hasAsked = false;
  private palette: { key: unknown; table: Uint8Array } | undefined;
  private isStale = true;
  private tableIsStale = true;
  private band = 0;
  private movedAt = 0;
  private fence: WebGLSync | null = null;
  private scale = 0.5;
  private tracedAt = 0;

  constructor(
    private readonly store: Store,
    private readonly changed: () => void,
  ) {}

  get isShown(): boolean {
    return this.element.offsetParent !== null;
  }

  open(session: Session | undefined): void {
    this.session = session;
    this.scene = undefined;
    this.painter = undefined;
    this.ranges = undefined;
    this.hasAsked = false;
  }

  private async readRanges(session: Session): Promise<void> {
    const { size } = session.facts.levels[0]!;
    if ((size[0] * size[1] * size[2]) / 64 ** 3 > MOST_BLOCKS) return;
    try {
      const ranges = await session.volume.ranges();
      if (this.session !== session) return;
      this.ranges = ranges;
      this.scene = undefined;
      this.painter = undefined;
      this.changed();
    } catch {
      // Without them nothing is skipped before it is read; a failing server is told of by cells.
    }
  }

  forget(): void {
    this.gl = undefined;
    this.painter = undefined;
    this.scene = undefined;
    this.fence = null;
  }

  get size(): readonly [number, number] {
    const ratio = window.devicePixelRatio || 1;
    const rect = this.element.getBoundingClientRect();
    return [
      Math.max(1, Math.round(rect.width * ratio)),
      Math.max(1, Math.round(rect.height * ratio)),
    ];
  }

  private prepare(gl: Gl): boolean {
    const session = this.session;
    if (!session?.hasPreview) return false;
    if (!this.hasAsked) {
      this.hasAsked = true;
      void this.readRanges(session);
    }
    if (this.painter && this.gl === gl) return true;
    const { facts, preview } = session;
    let pages = 0;
    for (let k = 0; k <= preview; ++k) {
      const grid = pageGrid(facts.levels[k]!);
      pages += grid[0] * grid[1] * grid[2];
    }
    const longest = gl.getParameter(gl.MAX_3D_TEXTURE_SIZE) as number;
    const shape = atlasShape(pages, texelFormat(gl, facts.type).bytes, MOST_ATLAS_BYTES, longest);
    this.gl = gl;
    this.scene = new RayScene(facts, session.cells, new SlotTable(shape), preview, this.ranges);
    this.painter = new RayPainter(gl, facts, shape, preview);
    this.want();
    return true;
  }

  private get visible(): Visible {
    const state = this.store.now;
    if (this.session!.facts.kind === "labels") return (_, high) => high > 0;
    if (state.mode === "iso") return (_, high) => high >= state.iso;
    if (state.mode === "mip") return () => true;
    return (low, high) => largestOpacity(state.transfer, low, high) > 0;
  }

  /** The coarsest level whose samples are at most LONGEST_SAMPLE pixels long. */
  private wantedLevel(): number {
    const { facts, preview } = this.session!;
    const [w, h] = this.size;
    const g = facts.geometry;
    const { pixelMm } = raysOf(g, facts.levels[0]!.size, this.store.now.camera, w, h);
    for (let k = preview; k > 0; --k) {
      const f = facts.levels[k]!.factor;
      const longest = Math.max(...f.map((v, a) => v * g.spacing[a as 0]!));
      if (longest <= LONGEST_SAMPLE * pixelMm) return k;
    }
    return 0;
  }

  want(): void {
    const session = this.session;
    if (!session) return;
    if (!this.scene || !this.isShown || !session.hasPreview) {
      session.cells.want("3d", []);
      return;
    }
    session.cells.want("3d", this.scene.plan(this.wantedLevel(), this.visible, this.clip));
    this.tableIsStale = true;
    this.moved();
  }

  private get clip(): Box {
    return this.store.now.clip;
  }

  /** Something that the picture depends on changed. */
  moved(): void {
    this.isStale = true;
    this.band = 0;
    this.movedAt = performance.now();
    this.changed();
  }

  /** More cells are here. */
  arrived(): void {
    if (this.scene) this.changed();
  }

  private get look(): RayLook {
    const state = this.store.now;
    const { facts } = this.session!;
    const spacing = Math.min(...facts.geometry.spacing);
    const isLabels = facts.kind === "labels";
    const span = isLabels ? ([0, COLORS] as const) : transferSpan(state.transfer);
    const key = isLabels ? state.hiddenLabels : state.transfer;
    if (this.palette?.key !== key) {
      this.palette = {
        key,
        table: isLabels ? this.labelPalette() : transferTable(state.transfer, span, COLORS),
      };
    }
    return {
      mode: isLabels ? "volume" : state.mode,
      iso: state.iso,
      window: state.window,
      palette: this.palette.table,
      span,
      layerMm: facts.unit === "HU" && facts.isSpacingKnown ? 1 : spacing,
      clip: this.clip,
    };
  }

  private labelPalette(): Uint8Array {
    const { labels } = this.session!.facts;
    const hidden = this.store.now.hiddenLabels;
    const table = new Uint8Array(4 * COLORS);
    const known = new Set([...labels.keys(), ...this.session!.labelsSeen().keys()]);
    for (let i = 1; i < COLORS; ++i) table.set([...colorOf(labels, i), 255], 4 * i);
    for (const label of known) {
      const at = 4 * (((label % COLORS) + COLORS) % COLORS);
      table.set([...colorOf(labels, label), hidden.has(label) ? 0 : 255], at);
    }
    return table;
  }

  /** Whether the graphics card has drawn what it was given last. */
  private isReady(gl: Gl): boolean {
    if (!this.fence) return true;
    const state = gl.clientWaitSync(this.fence, 0, 0);
    if (state === gl.TIMEOUT_EXPIRED) return false;
    gl.deleteSync(this.fence);
    this.fence = null;
    const took = performance.now() - this.tracedAt;
    if (this.band === 0 && took > 0) {
      this.scale = Math.max(0.12, Math.min(1, this.scale * Math.sqrt(40 / took)));
    }
    return true;
  }

  /** Draws; gives whether another frame is needed. */
  draw(gl: Gl, viewport: Viewport, canvasHeight: number, behind: Vec3): boolean {
    if (!this.isShown || !this.session || !this.prepare(gl)) return false;
    const { painter, scene } = this;
    if (!painter || !scene) return false;
    let isMore = false;
    if (scene.load(painter, PAGES_PER_FRAME)) {
      this.tableIsStale = true;
      this.isStale = true;
      this.band = 0;
      isMore = true;
    }
    if (this.tableIsStale) {
      painter.setTable({ level: scene.level, grid: scene.grid, ...scene.table() });
      this.tableIsStale = false;
      this.isStale = true;
    }
    isMore = this.trace(gl, painter) || isMore;
    painter.draw(viewport, canvasHeight, behind);
    this.annotate(scene);
    return isMore;
  }

  private trace(gl: Gl, painter: RayPainter): boolean {
    const isMoving = performance.now() - this.movedAt < 180;
    if (!this.isStale && this.band >= BAND_COUNT) return false;
    if (!this.isReady(gl)) return true;
    const [w, h] = this.size;
    const { camera } = this.store.now;
    if (this.isStale) {
      const s = painter.hasPicture || isMoving ? this.scale : 0.25;
      painter.trace(camera, this.look, Math.ceil(w * s), Math.ceil(h * s), 0.8);
      this.isStale = false;
      this.band = 0;
    } else if (!isMoving) {
      painter.trace(camera, this.look, w, h, 1.6, this.band);
      this.band += 1;
    } else {
      return true;
    }
    this.tracedAt = performance.now();
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    return true;
  }

  /** The level that is seen, as text; and whether a finer one is wanted. */
  fidelity(): { level: number; isFinal: boolean } | undefined {
    if (!this.scene || !this.isShown) return undefined;
    const level = this.scene.shownLevel();
    return { level, isFinal: level === this.scene.level };
  }

  get isSettled(): boolean {
    return !this.isStale && this.band >= BAND_COUNT;
  }

  private annotate(scene: RayScene): void {
    const [width, height] = this.size;
    const ratio = window.devicePixelRatio || 1;
    if (this.lines.width !== width) this.lines.width = width;
    if (this.lines.height !== height) this.lines.height = height;
    const pen = this.lines.getContext("2d")!;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, width, height);
    const { facts } = this.session!;
    const shown = levelText(facts.levels[scene.shownLevel()]!);
    this.element.setAttribute("aria-label", `3-D view, ${shown} of full resolution`);
    if (!this.store.now.hasAnnotations) return;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const [w, h] = [width / ratio, height / ratio];
    const axes = viewAxes(this.store.now.camera);
    pen.font = "bold 14px system-ui, sans-serif";
    pen.fillStyle = getComputedStyle(this.element).color;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    if (facts.isPlaceKnown) {
      const side = (v: Vec3, times: number): string =>
        sideLetter(v.map((c) => c * times) as unknown as Vec3);
      pen.fillText(side(axes.right, -1), 14, h / 2);
      pen.fillText(side(axes.right, 1), w - 14, h / 2);
      pen.fillText(side(axes.up, 1), w / 2, 14);
      pen.fillText(side(axes.up, -1), w / 2, h - 14);
    }
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "left";
    pen.textBaseline = "top";
    pen.fillText(`3-D · ${shown} of full resolution`, 8, 8);
  }

  get overlayCanvas(): HTMLCanvasElement {
    return this.lines;
  }
}

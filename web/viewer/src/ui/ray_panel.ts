// The 3-D view: a scan, labels, or labels over a scan; when rays are traced anew, and how finely.
import { type Box, type Vec3 } from "../reader/volume.js";
import { type Store } from "../store/state.js";
import { raysOf, viewAxes } from "../view/camera.js";
import { boxIn, levelText, sideLetters, toIndex, toWorld } from "../view/geometry.js";
import { type Gl } from "../view/gl.js";
import { colorOf } from "../view/label_color.js";
import { BAND_COUNT, type RayLook, RayPainter, type RayVolumes } from "../view/ray_painter.js";
import { type Visible } from "../view/ray_scene.js";
import { GREY_COLORS } from "../view/ray_shader.js";
import { type Viewport } from "../view/slice_painter.js";
import { largestOpacity, transferSpan, transferTable } from "../view/transfer.js";
import { captionTop, drawScaleBar } from "./annotations.js";
import { byId } from "./dom.js";
import { RayVolume } from "./ray_volume.js";
import { type Session } from "./session.js";

const MOST_ATLAS_BYTES = 64 << 20;
const MOST_LABEL_BYTES = 32 << 20;
const PAGES_PER_FRAME = 48;

/** What the picture on the screen is made of. */
interface Pictured {
  readonly level: number;
  readonly isFinest: boolean;
  /** Drawn with few rays, while something moves or arrives. */
  readonly isDraft: boolean;
}

/** A table of colors and what it was made of. */
interface Palette {
  readonly key: readonly unknown[];
  readonly table: Uint8Array;
}

const EMPTY = new Uint8Array(0);

export class RayPanel {
  readonly element = byId("panel-3d");
  private readonly lines = this.element.querySelector("canvas")!;
  private scan: RayVolume | undefined;
  private overlay: RayVolume | undefined;
  private painter: RayPainter | undefined;
  private painted: RayVolumes | undefined;
  private gl: Gl | undefined;
  private greyPalette: Palette | undefined;
  private labelPalette: Palette | undefined;
  private pictured: Pictured | undefined;
  private isStale = true;
  private band = 0;
  private movedAt = 0;
  private fence: WebGLSync | null = null;
  private scale = 0.5;
  private tracedAt = 0;
  /** In pixels, of the picture that is drawn. */
  private tracedSize: readonly [number, number] = [0, 0];

  constructor(
    private readonly store: Store,
    private readonly changed: () => void,
  ) {}

  get isShown(): boolean {
    return this.element.offsetParent !== null;
  }

  /** Shows a scan, or labels alone; what was shown before gives its textures back. */
  open(session: Session | undefined): void {
    this.openOverlay(undefined);
    this.scan?.close();
    this.scan = session && new RayVolume(session, MOST_ATLAS_BYTES, () => this.want());
    this.forgetPicture();
  }

  openOverlay(session: Session | undefined): void {
    this.overlay?.close();
    this.overlay = session && new RayVolume(session, MOST_LABEL_BYTES, () => this.want());
    this.moved();
  }

  private forgetPicture(): void {
    this.painter?.dispose();
    this.painter = undefined;
    this.painted = undefined;
    this.pictured = undefined;
  }

  /** The graphics context was lost. */
  forget(): void {
    this.scan?.forget();
    this.overlay?.forget();
    this.forgetPicture();
    this.gl = undefined;
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

  private get hasOverlay(): boolean {
    return this.overlay?.isReady === true && this.store.now.overlayOpacity > 0;
  }

  /** A painter for what is there now: another shader where labels came or went. */
  private prepare(gl: Gl): RayPainter | undefined {
    const main = this.scan?.atlas(gl);
    if (!main) return undefined;
    const isLabels = main.facts.kind === "labels";
    const over = this.hasOverlay ? this.overlay?.atlas(gl) : undefined;
    const volumes = { grey: isLabels ? undefined : main, labels: isLabels ? main : over };
    const { painted } = this;
    const isSame = painted?.grey === volumes.grey && painted?.labels === volumes.labels;
    if (this.painter && this.gl === gl && isSame) return this.painter;
    this.forgetPicture();
    this.gl = gl;
    this.painted = volumes;
    this.painter = new RayPainter(gl, volumes);
    this.want();
    return this.painter;
  }

  private get visible(): Visible {
    const state = this.store.now;
    if (state.mode === "iso") return (_, high) => high >= state.iso;
    if (state.mode === "mip") return () => true;
    return (low, high) => largestOpacity(state.transfer, low, high) > 0;
  }

  private get visibleLabels(): Visible {
    const hidden = this.store.now.hiddenLabels;
    return (low, high) => (low === high ? low !== 0 && !hidden.has(low) : true);
  }

  private get pixelMm(): number {
    const { facts } = this.scan!.session;
    const [w, h] = this.size;
    const { size } = facts.levels[0]!;
    return raysOf(facts.geometry, size, this.store.now.camera, w, h).pixelMm;
  }

  want(): void {
    const { scan, overlay } = this;
    if (!scan) return;
    if (!this.painter || !this.isShown) {
      scan.want(undefined);
      overlay?.want(undefined);
      return;
    }
    const { pixelMm } = this;
    const { clip } = this.store.now;
    const isLabels = scan.session.facts.kind === "labels";
    scan.want({ pixelMm, visible: isLabels ? this.visibleLabels : this.visible, clip });
    overlay?.want(
      this.hasOverlay
        ? { pixelMm, visible: this.visibleLabels, clip: this.clipOf(overlay.session) }
        : undefined,
    );
    this.moved();
  }

  /** The clip box among the voxels of labels over the scan. */
  private clipOf(over: Session): Box {
    const { geometry } = this.scan!.session.facts;
    const to = (v: Vec3): Vec3 => toIndex(over.facts.geometry, toWorld(geometry, v));
    return boxIn(this.store.now.clip, to, over.facts.levels[0]!.size);
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
    if (this.scan) this.changed();
  }

  private get look(): RayLook {
    const state = this.store.now;
    const { facts } = this.scan!.session;
    const isLabels = facts.kind === "labels";
    const span = isLabels ? ([0, 1] as const) : transferSpan(state.transfer);
    const labels = isLabels ? this.scan : this.hasOverlay ? this.overlay : undefined;
    return {
      mode: isLabels ? "volume" : state.mode,
      iso: state.iso,
      window: state.window,
      greyColors: isLabels ? EMPTY : this.greyColors(span),
      span,
      layerMm:
        facts.unit === "HU" && facts.isSpacingKnown ? 1 : Math.min(...facts.geometry.spacing),
      labelColors: labels ? this.labelColors(labels) : EMPTY,
      labelShare: isLabels ? 1 : state.overlayOpacity,
      clip: state.clip,
    };
  }

  private greyColors(span: readonly [number, number]): Uint8Array {
    const { transfer } = this.store.now;
    if (this.greyPalette?.key[0] !== transfer) {
      this.greyPalette = { key: [transfer], table: transferTable(transfer, span, GREY_COLORS) };
    }
    return this.greyPalette.table;
  }

  private labelColors(of: RayVolume): Uint8Array {
    const hidden = this.store.now.hiddenLabels;
    const index = of.index!;
    const key = [index, index.labels.length, hidden];
    if (!this.labelPalette || key.some((part, i) => part !== this.labelPalette!.key[i])) {
      const { labels } = of.session.facts;
      const table = index.table((label) => [
        ...colorOf(labels, label),
        hidden.has(label) ? 0 : 255,
      ]);
      this.labelPalette = { key, table };
    }
    return this.labelPalette.table;
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
    if (!this.isShown || !this.scan) return false;
    const painter = this.prepare(gl);
    if (!painter) return false;
    if (!this.isOfThisSize) this.moved();
    let isMore = false;
    for (const volume of [this.scan, this.hasOverlay ? this.overlay : undefined]) {
      if (!volume) continue;
      const loaded = volume.load(PAGES_PER_FRAME);
      if (loaded.isChanged) {
        this.isStale = true;
        this.band = 0;
      }
      isMore ||= loaded.isMore;
    }
    isMore = this.trace(gl, painter) || isMore;
    painter.draw(viewport, canvasHeight, behind);
    this.annotate();
    return isMore;
  }

  private trace(gl: Gl, painter: RayPainter): boolean {
    const isMoving = performance.now() - this.movedAt < 180;
    if (!this.isStale && this.band >= BAND_COUNT) return false;
    if (!this.isReady(gl)) return true;
    const [w, h] = this.size;
    const { camera } = this.store.now;
    this.tracedSize = [w, h];
    if (this.isStale) {
      const s = painter.hasPicture || isMoving ? this.scale : 0.25;
      painter.trace(camera, this.look, Math.ceil(w * s), Math.ceil(h * s), 0.8);
      this.pictured = { ...this.shown(), isDraft: true };
      this.isStale = false;
      this.band = 0;
    } else if (!isMoving) {
      const isWhole = painter.trace(camera, this.look, w, h, 1.6, this.band);
      // Whatever changes on the way begins a new picture.
      if (isWhole) this.pictured = { ...this.shown(), isDraft: false };
      this.band += 1;
    } else {
      return true;
    }
    this.tracedAt = performance.now();
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    return true;
  }

  /** What a picture that is drawn now consists of. */
  private shown(): { level: number; isFinest: boolean } {
    const scan = this.scan!.shown();
    const isFinest = scan.isFinest && (!this.hasOverlay || this.overlay!.shown().isFinest);
    return { level: scan.level, isFinest };
  }

  /** The level of the picture on the screen; and whether a better one is on its way. */
  fidelity(): { level: number; isFinal: boolean } | undefined {
    if (!this.pictured || !this.isShown) return undefined;
    const { level, isFinest, isDraft } = this.pictured;
    return { level, isFinal: isFinest && !isDraft };
  }

  private get isOfThisSize(): boolean {
    return this.size.every((side, i) => side === this.tracedSize[i]);
  }

  get isSettled(): boolean {
    return !this.isStale && this.band >= BAND_COUNT && this.isOfThisSize;
  }

  private annotate(): void {
    const [width, height] = this.size;
    const ratio = window.devicePixelRatio || 1;
    if (this.lines.width !== width) this.lines.width = width;
    if (this.lines.height !== height) this.lines.height = height;
    const pen = this.lines.getContext("2d")!;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, width, height);
    const { facts } = this.scan!.session;
    const level = this.pictured?.level ?? this.scan!.session.preview;
    const draft = this.pictured?.isDraft === false ? "" : ", draft";
    const shown = `${levelText(facts.levels[level]!)} of full resolution${draft}`;
    this.element.setAttribute("aria-label", `3-D view, ${shown}`);
    if (!this.store.now.hasAnnotations) return;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const [w, h] = [width / ratio, height / ratio];
    const axes = viewAxes(this.store.now.camera);
    pen.font = "bold 14px system-ui, sans-serif";
    const color = getComputedStyle(this.element).color;
    pen.fillStyle = color;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    if (facts.isPlaceKnown) {
      const side = (v: Vec3, times: number): string =>
        sideLetters(v.map((c) => c * times) as unknown as Vec3);
      pen.fillText(side(axes.right, -1), 14, h / 2);
      pen.fillText(side(axes.right, 1), w - 14, h / 2);
      pen.fillText(side(axes.up, 1), w / 2, 14);
      pen.fillText(side(axes.up, -1), w / 2, h - 14);
    }
    // Rays are parallel: a length is the same at any depth.
    if (facts.isSpacingKnown) {
      drawScaleBar(pen, { mmPerPixel: this.pixelMm * ratio, width: w, y: h - 12, color });
    }
    pen.font = "12px system-ui, sans-serif";
    pen.fillStyle = color;
    pen.textAlign = "left";
    pen.textBaseline = "top";
    const caption = `3-D · ${shown}`;
    pen.fillText(caption, 8, captionTop(pen, w, facts, caption));
  }

  get overlayCanvas(): HTMLCanvasElement {
    return this.lines;
  }
}

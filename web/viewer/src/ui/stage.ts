// The canvas behind all panels: one graphics context, one frame at a time, and what happens when
// the context is lost.
import { type Vec3 } from "../reader/volume.js";
import { type Gl, ShaderError } from "../view/gl.js";
import { SlicePainter, type Viewport } from "../view/slice_painter.js";
import { byId } from "./dom.js";
import { type RayPanel } from "./ray_panel.js";
import { type SlicePanel } from "./slice_panel.js";

const LOST = "The graphics card was lost; the picture comes back with it.";

export class Stage {
  readonly canvas = byId<HTMLCanvasElement>("stage");
  private gl: Gl | null = null;
  private painter: SlicePainter | undefined;
  private isAsked = false;
  private framesDrawn = 0;

  constructor(
    private readonly slices: readonly SlicePanel[],
    private readonly rays: RayPanel,
    private readonly fail: (text: string) => void,
    private readonly isBack: (text: string) => void,
    private readonly drawn: () => void,
  ) {
    this.canvas.addEventListener("webglcontextlost", (event) => {
      // Without this the browser never gives the context back.
      event.preventDefault();
      this.gl = null;
      // While it is lost: later these would be foreign to the context that comes back.
      this.forget();
      this.fail(LOST);
    });
    this.canvas.addEventListener("webglcontextrestored", () => {
      this.isBack(LOST);
      this.start();
      this.ask();
    });
    new ResizeObserver(() => this.ask()).observe(this.canvas);
    this.start();
  }

  private start(): void {
    this.gl = this.canvas.getContext("webgl2", {
      alpha: false,
      antialias: false,
      depth: false,
      preserveDrawingBuffer: false,
    });
    if (!this.gl) {
      this.fail("This browser gives no WebGL 2, without which nothing can be drawn.");
      return;
    }
    this.gl.enable(this.gl.SCISSOR_TEST);
    const mostSamples = this.gl.getParameter(this.gl.MAX_TEXTURE_SIZE) as number;
    for (const panel of this.slices) panel.mostSamples = mostSamples;
    try {
      this.painter = new SlicePainter(this.gl);
    } catch (error) {
      if (!(error instanceof ShaderError)) throw error;
      this.fail(`The graphics card does not take a shader: ${error.message}`);
    }
  }

  private forget(): void {
    for (const panel of this.slices) panel.forget();
    this.rays.forget();
  }

  get frames(): number {
    return this.framesDrawn;
  }

  /** Draws at the next frame. */
  ask(): void {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame(() => {
      this.isAsked = false;
      if (this.draw()) this.ask();
    });
  }

  private viewport(panel: { element: HTMLElement; size: readonly [number, number] }): Viewport {
    const ratio = window.devicePixelRatio || 1;
    const from = this.canvas.getBoundingClientRect();
    const rect = panel.element.getBoundingClientRect();
    return {
      x: Math.round((rect.left - from.left) * ratio),
      y: Math.round((rect.top - from.top) * ratio),
      width: panel.size[0],
      height: panel.size[1],
    };
  }

  private behind(): Vec3 {
    const text = getComputedStyle(this.rays.element).getPropertyValue("--scene").trim();
    const parts = text.split(",").map(Number);
    return parts.length === 3 && parts.every(Number.isFinite)
      ? (parts.map((v) => v / 255) as unknown as Vec3)
      : [0, 0, 0];
  }

  /** Gives whether another frame is needed. */
  draw(): boolean {
    const { gl, painter } = this;
    if (!gl || !painter || gl.isContextLost()) return false;
    const ratio = window.devicePixelRatio || 1;
    const rect = this.canvas.getBoundingClientRect();
    const width = Math.max(1, Math.round(rect.width * ratio));
    const height = Math.max(1, Math.round(rect.height * ratio));
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.scissor(0, 0, width, height);
    gl.clearColor(0, 0, 0, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    for (const panel of this.slices) {
      if (panel.isShown) panel.draw(painter, this.viewport(panel), height);
    }
    let isMore = false;
    if (this.rays.isShown) {
      const behind = this.behind();
      const viewport = this.viewport(this.rays);
      gl.scissor(
        viewport.x,
        height - viewport.y - viewport.height,
        viewport.width,
        viewport.height,
      );
      gl.clearColor(behind[0], behind[1], behind[2], 1);
      gl.clear(gl.COLOR_BUFFER_BIT);
      isMore = this.rays.draw(gl, viewport, height, behind);
    }
    this.framesDrawn += 1;
    this.drawn();
    return isMore;
  }

  /** Everything that is seen, with what is written over it, as a PNG. */
  async picture(): Promise<Blob> {
    this.draw();
    const { width, height } = this.canvas;
    const copy = document.createElement("canvas");
    copy.width = width;
    copy.height = height;
    const pen = copy.getContext("2d")!;
    pen.drawImage(this.canvas, 0, 0);
    for (const panel of [...this.slices, this.rays]) {
      if (!panel.isShown) continue;
      const at = this.viewport(panel);
      pen.drawImage(panel.overlayCanvas, at.x, at.y);
    }
    return new Promise((resolve, reject) =>
      copy.toBlob(
        (blob) => (blob ? resolve(blob) : reject(new Error("the picture could not be written"))),
        "image/png",
      ),
    );
  }
}

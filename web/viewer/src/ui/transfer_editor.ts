// The transfer function as a curve over a histogram: points are dragged, added by a double click,
// removed by a double click on them, and moved by arrow keys.
import { type Store } from "../store/state.js";
import {
  type Transfer,
  colorAt,
  transferSpan,
  withNewPoint,
  withPoint,
  withoutPoint,
} from "../view/transfer.js";
import { byId, element } from "./dom.js";
import { roundedTo } from "../view/window.js";

const NEAR = 9;
const BINS = 128;

export class TransferEditor {
  private readonly canvas = byId<HTMLCanvasElement>("transfer");
  private readonly points = byId("transfer-points");
  private dragged: number | undefined;
  private shown: readonly [number, number] = [0, 1];

  constructor(
    private readonly store: Store,
    private readonly histogram: (span: readonly [number, number], bins: number) => Float64Array,
  ) {
    const c = this.canvas;
    c.addEventListener("pointerdown", (event) => {
      this.dragged = this.pointAt(event);
      if (this.dragged !== undefined) c.setPointerCapture(event.pointerId);
    });
    c.addEventListener("pointermove", (event) => this.drag(event));
    c.addEventListener("pointerup", () => {
      this.dragged = undefined;
    });
    c.addEventListener("dblclick", (event) => this.addOrRemove(event));
    // Settings that were hidden have no size before they are shown.
    new ResizeObserver(() => this.draw()).observe(c);
  }

  private get transfer(): Transfer {
    return this.store.now.transfer;
  }

  /** What lies under the curve: its own values with as much again around them. */
  private span(): readonly [number, number] {
    if (this.dragged !== undefined) return this.shown;
    const [low, high] = transferSpan(this.transfer);
    const margin = (high - low) * 0.15;
    return [low - margin, high + margin];
  }

  place(value: number, opacity: number): [number, number] {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    const share = (value - this.shown[0]) / (this.shown[1] - this.shown[0]);
    return [share * w, h - 6 - opacity * (h - 14)];
  }

  private values(event: MouseEvent): [number, number] {
    const rect = this.canvas.getBoundingClientRect();
    const share = (event.clientX - rect.left) / rect.width;
    const opacity = (rect.height - 6 - (event.clientY - rect.top)) / (rect.height - 14);
    const span = this.shown[1] - this.shown[0];
    return [
      roundedTo(this.shown[0] + share * span, span),
      roundedTo(Math.max(0, Math.min(1, opacity)), 1),
    ];
  }

  private pointAt(event: MouseEvent): number | undefined {
    const rect = this.canvas.getBoundingClientRect();
    const found = this.transfer.findIndex((p) => {
      const [x, y] = this.place(p.value, p.opacity);
      return Math.hypot(event.clientX - rect.left - x, event.clientY - rect.top - y) < NEAR;
    });
    return found < 0 ? undefined : found;
  }

  private put(transfer: Transfer): void {
    this.store.set({ transfer, transferName: "own" });
  }

  private drag(event: PointerEvent): void {
    if (this.dragged === undefined) return;
    this.put(withPoint(this.transfer, this.dragged, ...this.values(event)));
  }

  private addOrRemove(event: MouseEvent): void {
    const at = this.pointAt(event);
    if (at !== undefined) this.put(withoutPoint(this.transfer, at));
    else this.put(withNewPoint(this.transfer, ...this.values(event)));
  }

  draw(): void {
    if (this.transfer.length === 0 || this.canvas.offsetParent === null) return;
    const c = this.canvas;
    const ratio = window.devicePixelRatio || 1;
    c.width = Math.max(1, Math.round(c.clientWidth * ratio));
    c.height = Math.max(1, Math.round(c.clientHeight * ratio));
    this.shown = this.span();
    const pen = c.getContext("2d")!;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.drawHistogram(pen);
    this.drawCurve(pen);
    this.listPoints();
  }

  private drawHistogram(pen: CanvasRenderingContext2D): void {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    const counts = this.histogram(this.shown, BINS);
    const most = Math.log1p(Math.max(...counts));
    if (!(most > 0)) return;
    pen.fillStyle = getComputedStyle(this.canvas).getPropertyValue("--faint");
    counts.forEach((count, i) => {
      const tall = (Math.log1p(count) / most) * (h - 10);
      pen.fillRect((i * w) / BINS, h - tall, w / BINS + 0.5, tall);
    });
  }

  private drawCurve(pen: CanvasRenderingContext2D): void {
    const { clientWidth: w } = this.canvas;
    const style = getComputedStyle(this.canvas);
    pen.strokeStyle = style.color;
    pen.lineWidth = 1.5;
    pen.beginPath();
    const ends = this.transfer;
    pen.moveTo(0, this.place(0, ends[0]!.opacity)[1]);
    for (const p of ends) pen.lineTo(...this.place(p.value, p.opacity));
    pen.lineTo(w, this.place(0, ends.at(-1)!.opacity)[1]);
    pen.stroke();
    for (const p of ends) {
      const [x, y] = this.place(p.value, p.opacity);
      const [r, g, b] = colorAt(this.transfer, p.value).map(Math.round);
      pen.fillStyle = `rgb(${r}, ${g}, ${b})`;
      pen.beginPath();
      pen.arc(x, y, 5, 0, 2 * Math.PI);
      pen.fill();
      pen.stroke();
    }
  }

  /** The same points as numbers, for keys and for those who do not see the curve. */
  private listPoints(): void {
    if (this.points.contains(document.activeElement)) return;
    this.points.replaceChildren(
      ...this.transfer.map((p, i) => {
        const value = element("input", {
          type: "number",
          step: "any",
          value: String(p.value),
          "aria-label": `Value of point ${i + 1}`,
        });
        const opacity = element("input", {
          type: "number",
          min: "0",
          max: "1",
          step: "0.01",
          value: String(p.opacity),
          "aria-label": `Opacity of point ${i + 1}`,
        });
        const [r, g, b] = p.color.map(Math.round) as [number, number, number];
        const hex = `#${[r, g, b].map((v) => v.toString(16).padStart(2, "0")).join("")}`;
        const color = element("input", {
          type: "color",
          value: hex,
          "aria-label": `Color of point ${i + 1}`,
        });
        const change = (): void => {
          const moved = withPoint(this.transfer, i, Number(value.value), Number(opacity.value));
          const rgb = [1, 3, 5].map((at) => parseInt(color.value.slice(at, at + 2), 16));
          this.put(moved.map((q, j) => (j === i ? { ...q, color: rgb as never } : q)));
        };
        for (const input of [value, opacity, color]) input.addEventListener("change", change);
        return element("div", { class: "point" }, color, value, opacity);
      }),
    );
  }
}

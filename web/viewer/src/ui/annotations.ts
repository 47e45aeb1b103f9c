// What is written over a slice: cursor, sides of the patient, scale bar, measurements.
import { type VolumeFacts } from "../reader/volume.js";
import { type ViewState } from "../store/state.js";
import { type Orientation } from "../view/geometry.js";
import { type Measurement, roundLength } from "../view/measure.js";
import { type SliceLook, pixelOfVoxel } from "../view/slice_look.js";
import { measurementText } from "./measure_text.js";

export interface Annotated {
  readonly facts: VolumeFacts;
  readonly orientation: Orientation;
  readonly look: SliceLook;
  readonly state: Readonly<ViewState>;
  readonly slice: number;
  /** Device pixels per pixel of the page. */
  readonly ratio: number;
  readonly title: string;
  readonly fidelity: string;
}

const AXIS_COLORS = ["#f06a6a", "#5fc46f", "#5aa2f5"] as const;
const TEXT = "#f4f6f8";
const HALO = "rgba(0, 0, 0, 0.75)";
const MEASURE = "#ffd54a";

type Pen = CanvasRenderingContext2D;

function write(pen: Pen, text: string, x: number, y: number, color = TEXT): void {
  pen.lineWidth = 3;
  pen.strokeStyle = HALO;
  pen.strokeText(text, x, y);
  pen.fillStyle = color;
  pen.fillText(text, x, y);
}

/** Scaled so that 1 is a pixel of the page. */
export function drawAnnotations(pen: Pen, a: Annotated): void {
  const { width, height } = pen.canvas;
  const [w, h] = [width / a.ratio, height / a.ratio];
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.clearRect(0, 0, width, height);
  if (!a.state.hasAnnotations) return;
  pen.setTransform(a.ratio, 0, 0, a.ratio, 0, 0);
  pen.lineJoin = "round";
  drawCursor(pen, a, w, h);
  for (const m of a.state.measurements) {
    if (m.axis === a.orientation.axis && m.slice === a.slice) drawMeasurement(pen, a, m);
  }
  drawSides(pen, a, w, h);
  if (a.facts.isSpacingKnown) {
    const mmPerPixel = a.look.pixelMm * a.ratio;
    drawScaleBar(pen, { mmPerPixel, width: w, y: h - 34, color: TEXT, halo: HALO });
  }
  pen.font = "12px system-ui, sans-serif";
  pen.textAlign = "left";
  pen.textBaseline = "top";
  const y = captionTop(pen, w, a.facts, a.title, a.fidelity);
  write(pen, a.title, 8, y);
  if (a.fidelity !== "") write(pen, a.fidelity, 8, y + 16, MEASURE);
}

/** Where captions at the left begin: beside the letter in the middle of the upper side, or below it
 *  where a panel is too narrow. */
export function captionTop(
  pen: Pen,
  width: number,
  facts: VolumeFacts,
  ...lines: readonly string[]
): number {
  const longest = Math.max(...lines.map((line) => pen.measureText(line).width));
  return facts.isPlaceKnown && 8 + longest > width / 2 - 14 ? 26 : 8;
}

function drawCursor(pen: Pen, a: Annotated, w: number, h: number): void {
  const o = a.orientation;
  const [px, py] = pixelOfVoxel(o, a.look.map, a.state.at).map((v) => v / a.ratio) as [
    number,
    number,
  ];
  const gap = 9;
  pen.lineWidth = 1;
  const line = (x0: number, y0: number, x1: number, y1: number): void => {
    pen.beginPath();
    pen.moveTo(x0, y0);
    pen.lineTo(x1, y1);
    pen.stroke();
  };
  pen.globalAlpha = 0.8;
  pen.strokeStyle = AXIS_COLORS[o.across];
  line(px, 0, px, py - gap);
  line(px, py + gap, px, h);
  pen.strokeStyle = AXIS_COLORS[o.down];
  line(0, py, px - gap, py);
  line(px + gap, py, w, py);
  pen.globalAlpha = 1;
}

function drawSides(pen: Pen, a: Annotated, w: number, h: number): void {
  if (!a.facts.isPlaceKnown) return;
  const o = a.orientation;
  pen.font = "bold 14px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  write(pen, o.left, 14, h / 2);
  write(pen, o.right, w - 14, h / 2);
  write(pen, o.top, w / 2, 14);
  write(pen, o.bottom, w / 2, h - 34);
}

/** A line of a round length at the right end of a picture, and its length; mm per pixel of the
 *  page. Halo: what lies around letters and lines over a picture. */
export function drawScaleBar(
  pen: Pen,
  of: { mmPerPixel: number; width: number; y: number; color: string; halo?: string },
): void {
  const { mm, text } = roundLength(of.mmPerPixel * Math.min(140, of.width * 0.3));
  const length = mm / of.mmPerPixel;
  const x = of.width - 12;
  pen.font = "12px system-ui, sans-serif";
  pen.textAlign = "right";
  pen.textBaseline = "bottom";
  for (const [stroke, thickness] of [
    [of.halo, 4],
    [of.color, 2],
  ] as const) {
    if (!stroke) continue;
    pen.strokeStyle = stroke;
    pen.lineWidth = thickness;
    pen.beginPath();
    pen.moveTo(x - length, of.y - 4);
    pen.lineTo(x - length, of.y);
    pen.lineTo(x, of.y);
    pen.lineTo(x, of.y - 4);
    pen.stroke();
  }
  if (of.halo) write(pen, text, x, of.y - 7, of.color);
  else {
    pen.fillStyle = of.color;
    pen.fillText(text, x, of.y - 7);
  }
}

function drawMeasurement(pen: Pen, a: Annotated, m: Measurement): void {
  const points = m.points.map(
    (p) => pixelOfVoxel(a.orientation, a.look.map, p).map((v) => v / a.ratio) as [number, number],
  );
  const [first, last] = [points[0], points.at(-1)];
  if (!first || !last) return;
  for (const [color, thickness] of [
    ["rgba(0,0,0,0.7)", 4],
    [MEASURE, 1.8],
  ] as const) {
    pen.strokeStyle = color;
    pen.lineWidth = thickness;
    pen.beginPath();
    if (m.kind === "roi") {
      pen.rect(first[0], first[1], last[0] - first[0], last[1] - first[1]);
    } else {
      points.forEach(([x, y], i) => (i === 0 ? pen.moveTo(x, y) : pen.lineTo(x, y)));
    }
    pen.stroke();
  }
  for (const [x, y] of points) {
    pen.fillStyle = MEASURE;
    pen.beginPath();
    pen.arc(x, y, 3, 0, 2 * Math.PI);
    pen.fill();
  }
  pen.font = "12px system-ui, sans-serif";
  pen.textAlign = "left";
  pen.textBaseline = "bottom";
  write(pen, measurementText(a.facts, m), Math.max(first[0], last[0]) + 6, last[1] - 4, MEASURE);
}

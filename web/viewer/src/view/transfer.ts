// What values look like in 3-D: a color and an opacity for each, straight between points.
import { type Vec3 } from "../reader/volume.js";
import { type Window } from "./window.js";

export interface TransferPoint {
  /** Real units. */
  readonly value: number;
  readonly color: Vec3;
  /** Of a layer of 1 mm, 0 .. 1. */
  readonly opacity: number;
}

export type Transfer = readonly TransferPoint[];

const point = (value: number, color: Vec3, opacity: number): TransferPoint => ({
  value,
  color,
  opacity,
});

/** For Hounsfield units. */
export const TRANSFER_PRESETS: ReadonlyMap<string, Transfer> = new Map<string, Transfer>([
  [
    "bone",
    [
      point(150, [214, 168, 128], 0),
      point(260, [232, 198, 160], 0.25),
      point(500, [250, 236, 212], 0.7),
      point(1500, [255, 252, 242], 0.95),
    ],
  ],
  [
    "skin",
    [
      point(-600, [222, 164, 132], 0),
      point(-350, [232, 178, 146], 0.16),
      point(-150, [226, 150, 120], 0.06),
      point(-60, [214, 110, 90], 0),
      point(150, [214, 168, 128], 0),
      point(300, [244, 224, 196], 0.4),
      point(1500, [255, 252, 242], 0.95),
    ],
  ],
  [
    "vessels",
    [
      point(140, [120, 10, 10], 0),
      point(200, [190, 32, 24], 0.12),
      point(320, [226, 72, 52], 0.5),
      point(450, [240, 196, 164], 0.5),
      point(900, [255, 246, 230], 0.8),
    ],
  ],
  [
    "lung",
    [
      point(-960, [90, 150, 210], 0),
      point(-880, [104, 166, 222], 0.012),
      point(-700, [150, 196, 232], 0.018),
      point(-520, [206, 150, 150], 0.03),
      point(-380, [214, 120, 110], 0),
      point(160, [226, 176, 140], 0),
      point(320, [248, 228, 200], 0.3),
      point(1200, [255, 250, 238], 0.8),
    ],
  ],
]);

/** One that suits any values: what lies low in the window is not seen. */
export function usualTransfer(window: Window): Transfer {
  const at = (share: number): number => window.center + (share - 0.5) * window.width;
  return [
    point(at(0.25), [110, 84, 66], 0),
    point(at(0.5), [196, 156, 120], 0.08),
    point(at(0.8), [236, 214, 184], 0.3),
    point(at(1), [255, 250, 240], 0.7),
  ];
}

function between(transfer: Transfer, value: number): [TransferPoint, TransferPoint, number] {
  const next = transfer.findIndex((p) => p.value > value);
  if (next < 0) return [transfer.at(-1)!, transfer.at(-1)!, 0];
  if (next === 0) return [transfer[0]!, transfer[0]!, 0];
  const [a, b] = [transfer[next - 1]!, transfer[next]!];
  return [a, b, (value - a.value) / (b.value - a.value)];
}

export function opacityAt(transfer: Transfer, value: number): number {
  const [a, b, share] = between(transfer, value);
  return a.opacity + (b.opacity - a.opacity) * share;
}

export function colorAt(transfer: Transfer, value: number): Vec3 {
  const [a, b, share] = between(transfer, value);
  return a.color.map((c, i) => c + (b.color[i]! - c) * share) as unknown as Vec3;
}

/** The largest opacity of any value from low to high. */
export function largestOpacity(transfer: Transfer, low: number, high: number): number {
  let largest = Math.max(opacityAt(transfer, low), opacityAt(transfer, high));
  for (const p of transfer) {
    if (p.value >= low && p.value <= high) largest = Math.max(largest, p.opacity);
  }
  return largest;
}

/** Values from the first to the last point, with a little beyond. */
export function transferSpan(transfer: Transfer): readonly [number, number] {
  const low = transfer[0]!.value;
  const high = transfer.at(-1)!.value;
  const margin = high > low ? (high - low) / 64 : 1;
  return [low - margin, high + margin];
}

/** `count` colors of four bytes over a span of values. */
export function transferTable(
  transfer: Transfer,
  span: readonly [number, number],
  count: number,
): Uint8Array {
  const table = new Uint8Array(4 * count);
  for (let i = 0; i < count; ++i) {
    const value = span[0] + ((span[1] - span[0]) * i) / (count - 1);
    table.set(colorAt(transfer, value).map(Math.round), 4 * i);
    table[4 * i + 3] = Math.round(255 * opacityAt(transfer, value));
  }
  return table;
}

/** With a point moved; it stays between its neighbors. */
export function withPoint(
  transfer: Transfer,
  number: number,
  value: number,
  opacity: number,
): Transfer {
  const low = transfer[number - 1]?.value ?? -Infinity;
  const high = transfer[number + 1]?.value ?? Infinity;
  return transfer.map((p, i) =>
    i === number
      ? {
          ...p,
          value: Math.min(high, Math.max(low, value)),
          opacity: Math.min(1, Math.max(0, opacity)),
        }
      : p,
  );
}

export function withNewPoint(transfer: Transfer, value: number, opacity: number): Transfer {
  const added = { value, color: colorAt(transfer, value), opacity };
  return [...transfer, added].sort((a, b) => a.value - b.value);
}

/** Without a point; two are always kept. */
export function withoutPoint(transfer: Transfer, number: number): Transfer {
  return transfer.length > 2 ? transfer.filter((_, i) => i !== number) : transfer;
}

// One color per label, the same as in pictures of the command line.
import { type LabelEntry, type Vec3 } from "../reader/volume.js";

const SHADES: readonly (readonly [number, number])[] = [
  [200, 255],
  [140, 230],
  [230, 175],
];
const GOLDEN_STEP = 40503; // 65536 / golden ratio

export function labelColor(label: number): Vec3 {
  if (label === 0) return [0, 0, 0];
  // A label below 0 counts as itself plus 2^64, which leaves 1 when divided by 3.
  const bits = ((label % 65536) + 65536) % 65536;
  const hue = (bits * GOLDEN_STEP) % 65536;
  const third = label < 0 ? (((label + 1) % 3) + 3) % 3 : label % 3;
  const [saturation, value] = SHADES[third]!;
  const scaled = hue * 6;
  const level = (share: number): number =>
    (value - Math.floor((value * saturation * share) / 65536)) & 255;
  const part = (scaled >> 8) & 255;
  const [high, low, rising, falling] = [level(0), level(256), level(256 - part), level(part)];
  const sectors: readonly Vec3[] = [
    [high, rising, low],
    [falling, high, low],
    [low, high, rising],
    [low, falling, high],
    [rising, low, high],
    [high, low, falling],
  ];
  return sectors[scaled >> 16] ?? sectors[5]!;
}

export function colorOf(labels: ReadonlyMap<number, LabelEntry>, label: number): Vec3 {
  return labels.get(label)?.color ?? labelColor(label);
}

export function nameOf(labels: ReadonlyMap<number, LabelEntry>, label: number): string {
  const name = labels.get(label)?.name ?? "";
  if (name !== "") return name;
  return label === 0 ? "background" : `label ${label}`;
}

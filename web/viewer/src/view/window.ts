// Which real values are black, and which white.

export interface Window {
  readonly center: number;
  readonly width: number;
}

/** The usual windows of CT, in HU; `octavo slice --window` has the same. */
export const WINDOW_PRESETS: ReadonlyMap<string, Window> = new Map([
  ["brain", { center: 40, width: 80 }],
  ["stroke", { center: 40, width: 40 }],
  ["bone", { center: 400, width: 1800 }],
  ["lung", { center: -600, width: 1500 }],
  ["mediastinum", { center: 50, width: 350 }],
  ["abdomen", { center: 50, width: 400 }],
  ["liver", { center: 30, width: 150 }],
]);

const IGNORED_SHARE = 0.005;

/** 0 .. 255; what is not a number is black. */
export function grey(window: Window, value: number): number {
  const share = (value - (window.center - window.width / 2)) / window.width;
  if (!(share > 0)) return 0;
  return Math.floor(255 * Math.min(share, 1) + 0.5);
}

/** What a center that is 0 may be off by, of the width. */
const ROUNDING = 1e-9;

function windowBetween(low: number, high: number): Window {
  const width = high > low ? high - low : 1;
  const center = low + width / 2;
  return { center: Math.abs(center) < ROUNDING * width ? 0 : center, width };
}

/** All of a range; of one value, what lies between it and 0: above 0 it is white, below black. */
export function wholeWindow(low: number, high: number): Window {
  return high > low
    ? windowBetween(low, high)
    : windowBetween(Math.min(0, low), Math.max(0, low));
}

/** From the 0.5th to the 99.5th percentile; the whole range where these are equal. The window of
 *  `octavo slice`. */
export function robustWindow(values: Iterable<number>): Window {
  const finite = Float64Array.from(values).filter(Number.isFinite).sort();
  if (finite.length === 0) return { center: 0, width: 1 };
  const at = (share: number): number => finite[Math.round(share * (finite.length - 1))]!;
  const low = at(IGNORED_SHARE);
  const high = at(1 - IGNORED_SHARE);
  return high > low ? windowBetween(low, high) : wholeWindow(finite[0]!, finite.at(-1)!);
}

/** The smallest float32 above 0. */
const NARROWEST = 2 ** -149;

/** A drag of so many pixels: to the right widens, upwards makes brighter. */
export function draggedWindow(from: Window, right: number, up: number): Window {
  const width = Math.max(from.width * Math.exp(right / 200), NARROWEST);
  return {
    center: roundedTo(from.center - (up * from.width) / 300, width),
    width: roundedTo(width, width),
  };
}

/** What a hand chose, without digits that nobody chose: to the fifth digit of a span. */
export function roundedTo(value: number, span: number): number {
  const places = 4 - Math.floor(Math.log10(span));
  if (!(span > 0 && span < Infinity) || places > 100) return value;
  if (places >= 0) return Number(value.toFixed(places));
  return Math.round(value / 10 ** -places) * 10 ** -places;
}

/** So many numbers of an address, where + stands for a space; undefined for anything else. */
export function numbers(text: string | null, count: number): number[] | undefined {
  const parts = text?.split(",").map((part) => part.trim().replace(" ", "+"));
  const isRight = parts?.length === count && parts.every((p) => p !== "" && isFinite(Number(p)));
  return isRight ? parts.map(Number) : undefined;
}

/** "40,80", or the name of a preset; undefined for anything else. */
export function parseWindow(text: string): Window | undefined {
  const [center, width] = numbers(text, 2) ?? [];
  return width! > 0 ? { center: center!, width: width! } : WINDOW_PRESETS.get(text);
}

/** A power of two near a number above 0; 1 of others. Shaders count very large and very small
 *  values in it: their floats end at 3.4e38 and 1.2e-38, and powers of two round nothing. */
export function powerOfTwo(value: number): number {
  return value > 0 && value < Infinity ? 2 ** Math.round(Math.log2(value)) : 1;
}

/** As few digits as tell the number, at most six or those before the point. */
export function shortNumber(value: number): string {
  return textOfDigits(value, 6);
}

/** As few digits as tell the number, at most so many or those before the point. */
export function textOfDigits(value: number, most: number): string {
  if (!Number.isFinite(value)) return String(value);
  const whole = Math.floor(Math.log10(Math.abs(value))) + 1;
  return String(Number(value.toPrecision(Math.min(17, Math.max(most, whole)))));
}

/** Read again, it is the same window. */
export function windowText(window: Window): string {
  return `${window.center},${window.width}`;
}

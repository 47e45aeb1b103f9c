// Real values as text, with the digits that find their voxels: those of `octavo probe`.
import { type VolumeFacts } from "../reader/volume.js";
import { type RoiStatistics } from "./measure.js";
import { textOfDigits } from "./window.js";

type Scale = Pick<VolumeFacts, "type" | "slope" | "intercept">;

const MAX_FLOAT = (2 - 2 ** -23) * 2 ** 127;
const FLOAT_STEP = 2 ** -23;

/** As few digits as round to the float32 nearest to a value; all of values beyond float32. */
function floatDigits(value: number): string {
  if (!(Math.abs(value) <= MAX_FLOAT)) return String(value);
  const float = Math.fround(value);
  let digits = 1;
  while (Math.fround(Number(float.toPrecision(digits))) !== float) digits += 1;
  return String(Number(float.toPrecision(digits)));
}

/** By how much a real value may differ from what is meant, as headers hold slopes and intercepts
 *  as float32: what ranges of `octavo threshold` allow for. Whole numbers are what is meant. */
function scaleRounding({ slope, intercept }: Scale, real: number): number {
  const part = (value: number, whole: number): number =>
    Number.isInteger(whole) ? 0 : FLOAT_STEP * Math.abs(value);
  const parts = part(real - intercept, slope) + part(intercept, intercept);
  return parts === 0 ? 0 : parts + (FLOAT_STEP / 2) * Math.abs(real);
}

/** A real value of a voxel: integers whole, others with the digits that find the voxel. */
export function realText(scale: Scale, real: number): string {
  const isInteger = scale.type !== "float32";
  if (isInteger && scale.slope === 1 && scale.intercept === 0) return String(real);
  const digits = floatDigits(real);
  // Integers may be closer to one another than the real values that float32 has.
  if (isInteger && scale.slope !== 0) {
    const most = Math.min(scaleRounding(scale, real), Math.abs(scale.slope) / 4);
    if (!(Math.abs(Number(digits) - real) <= most)) return String(real);
  }
  return digits;
}

/** The mean has the digits that the deviation asks for; smallest and largest are voxels. */
export function statisticsText(s: RoiStatistics, facts: Scale, unit: string): string {
  const of = unit === "" ? "" : ` ${unit}`;
  const ratio = Math.ceil(Math.log10(Math.abs(s.mean) / s.deviation));
  const mean =
    s.deviation > 0
      ? textOfDigits(s.mean, Math.min(15, Math.max(5, ratio + 4)))
      : realText(facts, s.mean);
  return (
    `mean ${mean} ± ${textOfDigits(s.deviation, 5)}${of}, ` +
    `${realText(facts, s.min)} to ${realText(facts, s.max)}${of}, ${s.count} samples`
  );
}

// Measurements in words. Statistics of a region stand in the list, with the level they are of.
import { type VolumeFacts } from "../reader/volume.js";
import {
  type Measurement,
  POINTS_NEEDED,
  angleDegrees,
  distanceMm,
} from "../view/measure.js";
import { shortNumber } from "../view/window.js";

export function lengthText(facts: VolumeFacts, mm: number): string {
  if (!facts.isSpacingKnown) return `${shortNumber(Number(mm.toFixed(1)))} voxels`;
  if (mm < 1) return `${(mm * 1000).toFixed(1)} µm`;
  return `${mm.toFixed(1)} mm`;
}

/** What stands beside a measurement; nothing while points are missing. */
export function measurementText(facts: VolumeFacts, m: Measurement): string {
  if (m.points.length < POINTS_NEEDED[m.kind]) return "";
  const g = facts.geometry;
  if (m.kind === "distance") return lengthText(facts, distanceMm(g, m.points[0]!, m.points[1]!));
  if (m.kind === "angle") return `${angleDegrees(g, m.points).toFixed(1)}°`;
  return "region";
}

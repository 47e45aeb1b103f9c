import assert from "node:assert/strict";
import test from "node:test";
import { type Geometry } from "../src/reader/volume.js";
import { orientationOf } from "../src/view/geometry.js";
import {
  angleDegrees,
  distanceMm,
  roiBox,
  roundLength,
  RegionSums,
} from "../src/view/measure.js";

const g: Geometry = {
  origin: [0, 0, 0],
  spacing: [0.5, 0.5, 3],
  direction: [1, 0, 0, 0, 1, 0, 0, 0, 1],
};

test("distances and angles are those of the body, not of the grid", () => {
  assert.equal(distanceMm(g, [0, 0, 0], [6, 8, 0]), 5);
  assert.equal(distanceMm(g, [0, 0, 0], [0, 8, 1]), 5);
  assert.ok(
    Math.abs(
      angleDegrees(g, [
        [6, 0, 0],
        [0, 0, 0],
        [0, 0, 1],
      ]) - 90,
    ) < 1e-9,
  );
  assert.ok(
    Math.abs(
      angleDegrees(g, [
        [6, 0, 0],
        [0, 0, 0],
        [6, 0, 1],
      ]) - 45,
    ) < 1e-9,
  );
  assert.ok(
    Number.isNaN(
      angleDegrees(g, [
        [1, 1, 1],
        [1, 1, 1],
        [2, 1, 1],
      ]),
    ),
  );
});

test("a region has the samples whose centers lie in it, at each level", () => {
  const o = orientationOf(g, 2);
  const fine = { size: [100, 100, 20] as const, factor: [1, 1, 1] as const };
  const coarse = { size: [50, 50, 20] as const, factor: [2, 2, 1] as const };
  const points = [
    [9.6, 20.2, 7],
    [19.4, 3, 7],
  ] as const;
  assert.deepEqual(roiBox(fine, o, 7, points), { lo: [10, 3, 7], hi: [20, 21, 8] });
  // Coarse sample i lies at voxel 2 i + 1/2.
  assert.deepEqual(roiBox(coarse, o, 7, points), { lo: [5, 2, 7], hi: [10, 10, 8] });
  const tiny = roiBox(fine, o, 7, [
    [4.2, 4.2, 7],
    [4.3, 4.3, 7],
  ]);
  assert.deepEqual(tiny, { lo: [5, 5, 7], hi: [6, 6, 8] });
});

test("statistics are of real values that are numbers, part by part", () => {
  const whole = { lo: [0, 0, 0], hi: [5, 1, 1] } as const;
  const sums = new RegionSums(2, -1);
  sums.add(Float32Array.of(9, 1, 2, 3, 9), whole, { lo: [1, 0, 0], hi: [4, 1, 1] });
  sums.add(Float32Array.of(9, 4, NaN, 9, 9), whole, { lo: [1, 0, 0], hi: [3, 1, 1] });
  const s = sums.statistics;
  assert.deepEqual([s.count, s.mean, s.min, s.max], [4, 4, 1, 7]);
  assert.ok(Math.abs(s.deviation - Math.sqrt(5)) < 1e-12);
  const voxels = Int16Array.from({ length: 27 }, (_, i) => i);
  const box = { lo: [10, 20, 30], hi: [13, 23, 33] } as const;
  const part = new RegionSums(1, 0);
  part.add(voxels, box, { lo: [11, 21, 32], hi: [13, 22, 33] });
  assert.deepEqual([part.statistics.count, part.statistics.min, part.statistics.max], [2, 22, 23]);
});

test("scale bars have round lengths", () => {
  assert.deepEqual(
    [73, 49, 20, 0.3, 0.011, 999, 1000, 280e3, 3e6].map((mm) => roundLength(mm).text),
    ["5 cm", "2 cm", "2 cm", "200 µm", "10 µm", "50 cm", "1 m", "200 m", "2 km"],
  );
  assert.equal(roundLength(9).text, "5 mm");
});

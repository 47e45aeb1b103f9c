import assert from "node:assert/strict";
import test from "node:test";
import { AXES, type Vec3 } from "../src/reader/volume.js";
import { type Cell, cellBox } from "../src/decode/cells.js";
import { orientationOf } from "../src/view/geometry.js";
import { pixelOfVoxel, sliceLook, voxelAtPixel } from "../src/view/slice_look.js";
import { sampleMap } from "../src/view/slice_painter.js";
import {
  MISSING,
  NOT_A_NUMBER,
  composePlane,
  labelPixels,
  planeCells,
  planeOfBox,
  planeRect,
  textureUnit,
  textureValues,
} from "../src/view/slice_plane.js";
import { MadeUpVolume, valueOf } from "./made_up_volume.js";

const size: Vec3 = [96, 112, 80];
const volume = new MadeUpVolume({ size });
const facts = volume.facts;
const never = new AbortController().signal;

async function readAll(): Promise<Map<string, Int16Array>> {
  const found = new Map<string, Int16Array>();
  for (let z = 0; z < 2; ++z) {
    for (let y = 0; y < 2; ++y) {
      for (let x = 0; x < 2; ++x) {
        const box = cellBox(facts.levels[0]!, [x, y, z]);
        found.set([x, y, z].join(), (await volume.read(0, box, never)) as Int16Array);
      }
    }
  }
  return found;
}

test("values that graphics cards take for 0 stand in textures in another unit", () => {
  const plane = (...values: number[]) => ({
    level: 0, slice: 0, from: [0, 0] as const, size: [values.length, 1] as const,
    values: Float32Array.from(values), isComplete: false,
  });
  const unit = textureUnit({ range: [-1.4e-45, 1e-42] });
  assert.ok(Number.isInteger(Math.log2(unit)));
  const tiny = plane(1e-42, -1.4e-45, 0, MISSING, NOT_A_NUMBER, 2.9e38, -2.9e38);
  const values = textureValues(tiny, unit);
  assert.ok(values[0]! > 0.5 && values[0]! < 2, String(values[0]));
  assert.deepEqual([...values.slice(0, 3)].map((v) => v * unit), [...tiny.values.slice(0, 3)]);
  assert.deepEqual([...values.slice(3)], [...tiny.values.slice(3)]);
  for (const range of [[-1000, 3000], [0, 0], [-1e-29, 0], [0, 3e38]] as const) {
    assert.equal(textureUnit({ range }), 1);
  }
  const usual = plane(1, 2, MISSING);
  assert.equal(textureValues(usual, 1), usual.values);
});

test("a plane holds the voxels of its slice, for each axis", async () => {
  const cells = await readAll();
  for (const axis of AXES) {
    const o = orientationOf(facts.geometry, axis);
    const slice = 50;
    const rect = planeRect(facts.levels, 0, o, slice, {
      lo: [0, 0],
      hi: [size[o.across] - 1, size[o.down] - 1],
    });
    const plane = composePlane(facts, o, rect, (cell: Cell) => cells.get(cell.at.join()));
    assert.equal(plane.isComplete, true);
    for (const [a, d] of [
      [0, 0],
      [65, 70],
      [30, 5],
      [size[o.across] - 1, size[o.down] - 1],
    ]) {
      const at = [0, 0, 0];
      at[axis] = slice;
      at[o.across] = a!;
      at[o.down] = d!;
      const value = plane.values[d! * plane.size[0] + a!];
      assert.equal(value, valueOf(size, at[0]!, at[1]!, at[2]!), `axis ${axis} at ${at}`);
    }
  }
});

test("what is not here is missing, and only that", async () => {
  const cells = await readAll();
  cells.delete("1,0,0");
  const o = orientationOf(facts.geometry, 2);
  const rect = planeRect(facts.levels, 0, o, 10, { lo: [0, 0], hi: [95, 111] });
  const plane = composePlane(facts, o, rect, (cell) => cells.get(cell.at.join()));
  assert.equal(plane.isComplete, false);
  assert.equal([...plane.values].filter((v) => v === MISSING).length, 32 * 64);
});

test("a rectangle covers what is seen, in whole cells, within the level", () => {
  const o = orientationOf(facts.geometry, 2);
  const rect = planeRect(facts.levels, 0, o, 10, { lo: [70, -20], hi: [200, 3] });
  assert.deepEqual(
    [rect.from, rect.size],
    [
      [64, 0],
      [32, 64],
    ],
  );
  assert.deepEqual(
    planeCells(o, rect).map((cell) => cell.at),
    [[1, 0, 0]],
  );
  const far = planeRect(facts.levels, 0, o, 10, { lo: [500, 500], hi: [600, 600] });
  assert.ok(far.size[0] > 0 && far.size[1] > 0);
});

test("what is no number of a float volume stands apart from what is missing", () => {
  const floats = { ...facts, type: "float32" as const };
  const o = orientationOf(facts.geometry, 2);
  const rect = planeRect(facts.levels, 0, o, 0, { lo: [0, 0], hi: [1, 1] });
  const voxels = new Float32Array(64 ** 3);
  voxels.set([NaN, Infinity, -Infinity, 2]);
  const plane = composePlane(floats, o, rect, () => voxels);
  assert.equal(plane.values[0], NOT_A_NUMBER);
  assert.ok(plane.values[1]! > 2e38 && plane.values[1]! < MISSING);
  assert.ok(plane.values[2]! < -2e38 && plane.values[2]! > NOT_A_NUMBER);
  assert.equal(plane.values[3], 2);
});

test("large labels keep their numbers, as no float of 32 bits does", () => {
  const labels = { ...facts, kind: "labels" as const, type: "uint32" as const };
  const o = orientationOf(facts.geometry, 2);
  const rect = planeRect(facts.levels, 0, o, 0, { lo: [0, 0], hi: [1, 1] });
  const voxels = new Uint32Array(64 ** 3);
  voxels.set([614454277, 16777217, 4294967295]);
  const seen = new Set<number>();
  const look = (label: number): readonly [number, number, number, number] => {
    seen.add(label);
    return [0, 0, 0, 0];
  };
  labelPixels(composePlane(labels, o, rect, () => voxels), look);
  assert.deepEqual([...seen], [614454277, 16777217, 4294967295, 0]);
  seen.clear();
  const row = { ...rect, size: [3, 1] as const };
  labelPixels(planeOfBox(labels, o, row, voxels.slice(0, 3)), look);
  assert.deepEqual([...seen], [614454277, 16777217, 4294967295]);
});

test("colors of labels: hidden and missing ones are clear", () => {
  const plane = {
    level: 0,
    slice: 0,
    from: [0, 0] as const,
    size: [4, 1] as const,
    isComplete: false,
    values: Float32Array.of(5, 5, 7, MISSING),
  };
  const pixels = labelPixels(plane, (label) => (label === 5 ? [1, 2, 3, 255] : [9, 9, 9, 0]));
  assert.deepEqual([...pixels], [1, 2, 3, 255, 1, 2, 3, 255, 9, 9, 9, 0, 0, 0, 0, 0]);
});

test("pixels and voxels are the same places, at the outer edge of the outermost voxel too", () => {
  const o = orientationOf(facts.geometry, 1);
  const look = sliceLook(facts, o, { center: undefined, zoom: 1 }, 96, 120);
  assert.equal(look.pixelMm, 1);
  const corner = voxelAtPixel(o, look.map, 7, 0, 0);
  assert.deepEqual(corner, [-0.5, 7, 79.5]);
  const [x, y] = pixelOfVoxel(o, look.map, voxelAtPixel(o, look.map, 7, 33, 44));
  assert.ok(Math.abs(x - 33) < 1e-9 && Math.abs(y - 44) < 1e-9);
  const [sx, , ox] = sampleMap(facts, o, 1, look.map);
  // Sample 0 of the level lies between voxels 0 and 1, a pixel and a half from the edge.
  assert.ok(Math.abs(sx * 1 + ox) < 1e-9);
});

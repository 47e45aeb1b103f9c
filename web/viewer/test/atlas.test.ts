import assert from "node:assert/strict";
import test from "node:test";
import { type Vec3 } from "../src/reader/volume.js";
import { cellBox } from "../src/decode/cells.js";
import {
  SLOT_SIDE,
  SlotTable,
  atlasShape,
  cellOfPage,
  nanWithin,
  pageGrid,
  pageKey,
  pageVoxels,
} from "../src/view/atlas.js";
import { MadeUpVolume, valueOf } from "./made_up_volume.js";

const size: Vec3 = [96, 112, 80];

test("an atlas has room for its pages within memory and the longest side", () => {
  const [x, y, z] = atlasShape(60, 2, 1 << 30, 2048);
  assert.ok(x * y * z >= 60 && x * y * z < 80);
  const [a, b, c] = atlasShape(1e6, 2, 64 << 20, 2048);
  assert.ok(a * b * c * SLOT_SIDE ** 3 * 2 <= 64 << 20);
  for (const side of atlasShape(1e6, 1, 2 ** 40, 256)) assert.ok(side * SLOT_SIDE <= 256);
  assert.deepEqual(atlasShape(1, 4, 1 << 20, 2048), [1, 1, 1]);
});

test("slots are given once, and taken from pages that nobody wants", () => {
  const table = new SlotTable([2, 1, 1]);
  const page = (x: number): { level: number; at: Vec3 } => ({ level: 0, at: [x, 0, 0] });
  assert.notEqual(table.take(page(0), new Set())!.number, table.take(page(1), new Set())!.number);
  assert.equal(table.take(page(2), new Set([0, 1].map((x) => pageKey(page(x))))), undefined);
  assert.ok(table.take(page(2), new Set([pageKey(page(1))])));
  assert.equal(table.find(page(0)), undefined);
  assert.ok(table.find(page(1)));
  assert.equal(table.used, 2);
});

test("a page has the samples around it, across cells and up to the end of the level", async () => {
  const volume = new MadeUpVolume({ size });
  const level = volume.facts.levels[0]!;
  const never = new AbortController().signal;
  const cells = new Map<string, Awaited<ReturnType<MadeUpVolume["read"]>>>();
  for (let n = 0; n < 8; ++n) {
    const at: Vec3 = [n & 1, (n >> 1) & 1, n >> 2];
    cells.set(at.join(), await volume.read(0, cellBox(level, at), never));
  }
  assert.deepEqual(pageGrid(level), [3, 4, 3]);
  for (const at of [
    [0, 0, 0],
    [1, 1, 1],
    [2, 3, 2],
  ] as Vec3[]) {
    const page = { level: 0, at };
    const found = pageVoxels(level, page, volume.facts.range, (cell) => cells.get(cell.at.join()))!;
    let [min, max] = [Infinity, -Infinity];
    for (let z = -1; z <= 32; ++z) {
      for (let y = -1; y <= 32; ++y) {
        for (let x = -1; x <= 32; ++x) {
          const sample = [x, y, z].map((v, a) =>
            Math.min(size[a]! - 1, Math.max(0, at[a]! * 32 + v)),
          ) as unknown as Vec3;
          const value = valueOf(size, ...sample);
          const i = ((z + 1) * SLOT_SIDE + y + 1) * SLOT_SIDE + x + 1;
          if (found.voxels[i] !== value) assert.fail(`page ${at} at ${x},${y},${z}`);
          min = Math.min(min, value);
          max = Math.max(max, value);
        }
      }
    }
    assert.deepEqual([found.min, found.max], [min, max]);
  }
});

test("without the cell beside it a page goes on as it ends", async () => {
  const volume = new MadeUpVolume({ size });
  const level = volume.facts.levels[0]!;
  const own = await volume.read(0, cellBox(level, [0, 0, 0]), new AbortController().signal);
  const page = { level: 0, at: [1, 0, 0] as Vec3 };
  assert.deepEqual(cellOfPage(page).at, [0, 0, 0]);
  const found = pageVoxels(level, page, volume.facts.range, (cell) =>
    cell.at.join() === "0,0,0" ? own : undefined,
  )!;
  const row = (10 * SLOT_SIDE + 10) * SLOT_SIDE;
  assert.equal(found.voxels[row + 33], found.voxels[row + 32]);
  assert.equal(
    pageVoxels(level, page, volume.facts.range, () => undefined),
    undefined,
  );
});

test("infinities count as the ends of the range, NaN lies as far below as it is wide", () => {
  const level = { size: [4, 1, 1] as Vec3, factor: [1, 1, 1] as Vec3 };
  const own = Float32Array.of(NaN, Infinity, 3, -Infinity);
  const found = pageVoxels(level, { level: 0, at: [0, 0, 0] }, [-2, 5], () => own)!;
  const row = SLOT_SIDE * (SLOT_SIDE + 1) + 1;
  assert.deepEqual([...found.voxels.subarray(row, row + 4)], [-9, 5, 3, -2]);
  // To modes that have no empty space NaN is the lowest value.
  assert.deepEqual([found.min, found.max], [-2, 5]);
  assert.equal(nanWithin([2, 2]), 0);
  assert.equal(nanWithin([0, 0]), -1);
  assert.ok(nanWithin([-3e38, 3e38]) > -3.5e38);
});

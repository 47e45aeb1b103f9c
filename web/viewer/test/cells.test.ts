import assert from "node:assert/strict";
import test from "node:test";
import { type Level } from "../src/reader/volume.js";
import {
  boxVoxels,
  cellBox,
  cellKey,
  cellsOf,
  previewLevel,
  wholeBox,
} from "../src/decode/cells.js";

const level: Level = { size: [130, 64, 65], factor: [1, 1, 1] };

test("cells cover a level once", () => {
  const cells = cellsOf(0, wholeBox(level));
  assert.deepEqual(cells.at(-1)?.at, [2, 0, 1]);
  assert.equal(cells.length, 6);
  assert.equal(new Set(cells.map(cellKey)).size, 6);
  const voxels = cells.reduce((sum, cell) => sum + boxVoxels(cellBox(level, cell.at)), 0);
  assert.equal(voxels, 130 * 64 * 65);
});

test("a box meets the cells that it touches, and no others", () => {
  const box = { lo: [63, 0, 64], hi: [65, 1, 65] } as const;
  assert.deepEqual(
    cellsOf(0, box).map((cell) => cell.at),
    [
      [0, 0, 1],
      [1, 0, 1],
    ],
  );
});

test("the level shown first is the finest of few samples", () => {
  const levels: Level[] = [512, 256, 128, 64, 32].map((n, k) => ({
    size: [n, n, 275 >> k],
    factor: [2 ** k, 2 ** k, 2 ** k],
  }));
  assert.equal(previewLevel(levels), 3);
  assert.equal(previewLevel(levels.slice(0, 2)), 1);
  // No longer than a texture may be.
  const long: Level[] = [12, 13, 14, 15].map((n) => ({
    size: [2 ** (26 - n), 1, 1],
    factor: [2 ** n, 1, 1],
  }));
  assert.equal(previewLevel(long), 2);
});

import assert from "node:assert/strict";
import test from "node:test";
import { LabelIndex } from "../src/view/label_index.js";

test("labels far apart have numbers of their own, and the background is 0", () => {
  const index = new LabelIndex();
  const voxels = Uint32Array.of(0, 7, 7, 1031, 4294967295, 7, 0);
  assert.deepEqual([...index.numbered(voxels)], [0, 1, 1, 2, 3, 1, 0]);
  assert.deepEqual([...index.numbered(Int16Array.of(-1, 7))], [4, 1]);
  assert.deepEqual(index.labels, [0, 7, 1031, 4294967295, -1]);
  const table = index.table((label) => [label === 1031 ? 9 : 1, 2, 3, 255]);
  assert.deepEqual([...table.subarray(0, 12)], [0, 0, 0, 0, 1, 2, 3, 255, 9, 2, 3, 255]);
});

test("more labels than there are numbers share those of others, never the first", () => {
  const index = new LabelIndex();
  const many = Uint32Array.from({ length: 70_000 }, (_, i) => i * 3);
  const numbers = index.numbered(many);
  assert.equal(index.labels.length, 65_536);
  assert.equal(new Set(numbers.subarray(0, 65_536)).size, 65_536);
  assert.ok(numbers.subarray(1).every((number) => number > 0));
  assert.deepEqual(index.numbered(many), numbers);
});

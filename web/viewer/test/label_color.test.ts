import assert from "node:assert/strict";
import test from "node:test";
import { colorOf, labelColor, nameOf } from "../src/view/label_color.js";

// As src/octavo/core/label_color.cpp gives them.
const KNOWN: [number, number[]][] = [
  [0, [0, 0, 0]],
  [1, [105, 142, 230]],
  [2, [110, 175, 18]],
  [3, [255, 56, 231]],
  [4, [105, 230, 209]],
  [5, [175, 103, 18]],
  [17, [18, 170, 175]],
  [255, [56, 140, 255]],
  [256, [194, 230, 105]],
  [1000, [230, 125, 105]],
  [65535, [56, 255, 114]],
  [65536, [230, 105, 105]],
  [4294967295, [56, 255, 114]],
  [-1, [56, 255, 114]],
  [-2, [110, 18, 175]],
  [-3, [230, 215, 105]],
  [-70000, [255, 210, 56]],
];

test("colors are those of pictures of the command line", () => {
  for (const [label, color] of KNOWN) assert.deepEqual([...labelColor(label)], color, `${label}`);
});

test("a file may name colors and labels", () => {
  const labels = new Map([[3, { name: "liver", color: [1, 2, 3] as const }]]);
  assert.deepEqual(colorOf(labels, 3), [1, 2, 3]);
  assert.deepEqual(
    [nameOf(labels, 3), nameOf(labels, 4), nameOf(labels, 0)],
    ["liver", "label 4", "background"],
  );
});

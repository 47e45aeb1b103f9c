import assert from "node:assert/strict";
import test from "node:test";
import {
  TRANSFER_PRESETS,
  colorAt,
  largestOpacity,
  opacityAt,
  transferSpan,
  transferTable,
  usualTransfer,
  withNewPoint,
  withPoint,
  withoutPoint,
} from "../src/view/transfer.js";

const bone = TRANSFER_PRESETS.get("bone")!;

test("between points opacity and color are straight, beyond them they stay", () => {
  assert.equal(opacityAt(bone, -1000), 0);
  assert.equal(opacityAt(bone, 205), 0.125);
  assert.equal(opacityAt(bone, 9999), 0.95);
  assert.deepEqual(colorAt(bone, 150), [214, 168, 128]);
});

test("the largest opacity of a range counts peaks inside it", () => {
  const skin = TRANSFER_PRESETS.get("skin")!;
  assert.equal(largestOpacity(skin, -1000, -700), 0);
  assert.equal(largestOpacity(skin, -500, -200), 0.16);
  assert.equal(largestOpacity(skin, -60, 150), 0);
});

test("a table runs over all points", () => {
  const span = transferSpan(bone);
  const table = transferTable(bone, span, 256);
  assert.equal(table[3], 0);
  assert.equal(table[4 * 255 + 3], 242);
});

test("points are moved between their neighbors, added in order, removed down to two", () => {
  assert.equal(withPoint(bone, 1, 9999, 2)[1]!.value, 500);
  assert.equal(withPoint(bone, 1, 300, 2)[1]!.opacity, 1);
  assert.deepEqual(
    withNewPoint(bone, 200, 0.5).map((p) => p.value),
    [150, 200, 260, 500, 1500],
  );
  const two = withoutPoint(withoutPoint(bone, 0), 0);
  assert.equal(two.length, 2);
  assert.equal(withoutPoint(two, 0).length, 2);
  assert.equal(usualTransfer({ center: 100, width: 40 })[0]!.value, 90);
});

import assert from "node:assert/strict";
import test from "node:test";
import { oCode, rootLevel } from "../src/view/o_code.js";

test("codes are those of the octree: 4 z + 2 x + y", () => {
  assert.equal(rootLevel([1, 1, 1]), 0);
  assert.equal(rootLevel([256, 256, 108]), 8);
  assert.equal(rootLevel([257, 1, 1]), 9);
  assert.equal(oCode([1, 0, 0], 1), "2");
  assert.equal(oCode([0, 1, 0], 1), "1");
  assert.equal(oCode([0, 2, 4], 3), "410");
  assert.equal(oCode([0, 0, 0], 0), "");
  assert.equal(oCode([2 ** 20, 0, 1], 21), `2${"0".repeat(19)}4`);
});

import assert from "node:assert/strict";
import test from "node:test";
import { realText, statisticsText } from "../src/view/value_text.js";

test("integers are whole, floats have the digits that find them", () => {
  const whole = { type: "uint32", slope: 1, intercept: 0 } as const;
  assert.equal(realText(whole, 3913030420), "3913030420");
  assert.equal(realText({ ...whole, type: "int32" }, -16777219), "-16777219");
  const float = { type: "float32", slope: 1, intercept: 0 } as const;
  assert.equal(realText(float, Math.fround(0.1)), "0.1");
  assert.equal(realText(float, 1000000.0625), "1000000.06");
  assert.equal(realText(float, 0), "0");
  assert.equal(realText(float, -0), "0");
  assert.equal(realText(float, 2 ** -149), "1e-45");
  assert.equal(realText(float, NaN), "NaN");
  assert.equal(realText(float, -Infinity), "-Infinity");
  for (let i = 0; i < 9; ++i) {
    const value = Math.fround(1 + i * 2 ** -20);
    assert.equal(Math.fround(Number(realText(float, value))), value);
  }
});

test("real values of integers have the digits that find the stored voxel", () => {
  assert.equal(realText({ type: "int16", slope: 0.1, intercept: 0 }, 0.1 * 3), "0.3");
  assert.equal(realText({ type: "int16", slope: 1, intercept: -1024 }, -1000), "-1000");
  assert.equal(realText({ type: "uint8", slope: 0, intercept: 0.1 }, 0.1), "0.1");
  for (const slope of [2, -2, 0.001, -0.25, 1 / 3]) {
    for (const intercept of [0, -1024, 0.5]) {
      for (const stored of [2 ** 31 - 2, -12345, 0, 1, 2 ** 24 + 1]) {
        const text = realText({ type: "int32", slope, intercept }, slope * stored + intercept);
        assert.ok(Math.round((Number(text) - intercept) / slope) === stored, text);
      }
    }
  }
});

test("statistics have the digits that tell the samples apart", () => {
  const whole = { type: "uint32", slope: 1, intercept: 0 } as const;
  const [min, max] = [3913030420, 3913030423];
  const s = { count: 3, mean: 3913030421.333, deviation: 1.2472191, min, max };
  assert.equal(
    statisticsText(s, whole, "HU"),
    "mean 3913030421.333 ± 1.2472 HU, 3913030420 to 3913030423 HU, 3 samples",
  );
  const one = { count: 2, mean: 16777219, deviation: 0, min: 16777219, max: 16777219 };
  assert.equal(
    statisticsText(one, whole, ""),
    "mean 16777219 ± 0, 16777219 to 16777219, 2 samples",
  );
});

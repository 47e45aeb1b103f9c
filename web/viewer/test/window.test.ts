import assert from "node:assert/strict";
import test from "node:test";
import {
  draggedWindow,
  grey,
  parseWindow,
  powerOfTwo,
  robustWindow,
  shortNumber,
  windowText,
} from "../src/view/window.js";

test("a window is black below, white above, and rounds in between", () => {
  const window = { center: 40, width: 80 };
  assert.deepEqual(
    [-5, 0, 40, 80, 500, NaN].map((v) => grey(window, v)),
    [0, 0, 128, 255, 255, 0],
  );
  assert.equal(grey({ center: 0, width: 255 }, 0.9), 128);
});

test("the automatic window leaves out half a percent at each end", () => {
  const values = Array.from({ length: 1001 }, (_, i) => i);
  assert.deepEqual(robustWindow(values), { center: 500, width: 990 });
  assert.deepEqual(robustWindow([7, 7, NaN]), { center: 7.5, width: 1 });
  assert.deepEqual(robustWindow([]), { center: 0, width: 1 });
});

test("windows are read from text, and what is none is not", () => {
  assert.deepEqual(parseWindow("bone"), { center: 400, width: 1800 });
  assert.deepEqual(parseWindow("-12.5,3"), { center: -12.5, width: 3 });
  for (const text of ["", "x", "1", "1,0", "1,-2", "1,2,3", "NaN,1", "1,Infinity", ","]) {
    assert.equal(parseWindow(text), undefined, text);
  }
  assert.equal(windowText({ center: 1 / 3, width: 1e6 }), "0.333333,1000000");
});

test("a drag to the right widens, one upwards lowers the center", () => {
  const from = { center: 100, width: 200 };
  assert.ok(draggedWindow(from, 50, 0).width > 200);
  assert.ok(draggedWindow(from, 0, 50).center < 100);
  assert.ok(draggedWindow(from, -1e5, 0).width > 0);
  assert.equal(shortNumber(Infinity), "Infinity");
});

test("units of shaders are powers of two near a value, of what has no size 1", () => {
  assert.deepEqual(
    [80, 1, 1e-40, 3.4e38, 0, -5, NaN, Infinity].map(powerOfTwo),
    [64, 1, 2 ** -133, 2 ** 128, 1, 1, 1, 1],
  );
});

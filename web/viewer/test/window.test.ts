import assert from "node:assert/strict";
import test from "node:test";
import {
  draggedWindow,
  grey,
  parseWindow,
  powerOfTwo,
  robustWindow,
  shortNumber,
  wholeWindow,
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
  assert.deepEqual(robustWindow([]), { center: 0, width: 1 });
});

test("one value lies between black and white at 0, as in pictures of `octavo slice`", () => {
  assert.deepEqual(robustWindow([7, 7, NaN]), { center: 3.5, width: 7 });
  assert.equal(grey(robustWindow([7, 7]), 7), 255);
  assert.deepEqual(robustWindow([-4]), { center: -2, width: 4 });
  assert.equal(grey(robustWindow([-4]), -4), 0);
  assert.deepEqual(wholeWindow(0, 0), { center: 0.5, width: 1 });
  assert.deepEqual(wholeWindow(5, 5), { center: 2.5, width: 5 });
  assert.deepEqual(wholeWindow(5, 9), { center: 7, width: 4 });
});

test("windows are read from text, and what is none is not", () => {
  assert.deepEqual(parseWindow("bone"), { center: 400, width: 1800 });
  assert.deepEqual(parseWindow("-12.5,3"), { center: -12.5, width: 3 });
  for (const text of ["", "x", "1", "1,0", "1,-2", "1,2,3", "NaN,1", "1,Infinity", ","]) {
    assert.equal(parseWindow(text), undefined, text);
  }
});

test("the text of a window is read as the same window", () => {
  const narrow = { center: 1.0000046889, width: 7.629394531e-6 };
  assert.equal(windowText(narrow), "1.0000046889,0.000007629394531");
  for (const window of [
    narrow,
    { center: 16777219, width: 3 },
    { center: 1 / 3, width: 1e-40 },
    { center: -1e30, width: 3e38 },
  ]) {
    assert.deepEqual(parseWindow(windowText(window)), window);
  }
});

test("a drag to the right widens, one upwards lowers the center", () => {
  const from = { center: 100, width: 200 };
  assert.ok(draggedWindow(from, 50, 0).width > 200);
  assert.ok(draggedWindow(from, 0, 50).center < 100);
  assert.ok(draggedWindow(from, -1e5, 0).width > 0);
  const tiny = draggedWindow({ center: 2e-42, width: 1e-42 }, 5, 5);
  assert.ok(tiny.width > 1e-42 && tiny.width < 1.1e-42, windowText(tiny));
  assert.ok(tiny.center > 1.9e-42 && tiny.center < 2e-42, windowText(tiny));
  for (const narrow of [1e-5, 1e-7, 1e-40]) {
    const { width } = draggedWindow({ center: 0, width: narrow }, -200, 0);
    assert.ok(Math.abs(width / narrow - Math.exp(-1)) < 1e-4, `${narrow} becomes ${width}`);
  }
  for (const center of [100, 1.000004, 2 ** 24, -3e9]) {
    const { width, center: moved } = draggedWindow({ center, width: 7e-3 }, 7, 3);
    assert.ok(String(width).length <= 9, String(width));
    assert.ok(Math.abs(moved - (center - 7e-5)) <= 1e-6, String(moved));
    assert.equal(Number(moved.toFixed(7)), moved);
  }
});

test("short numbers have six digits, and all of those before the point", () => {
  assert.equal(shortNumber(Infinity), "Infinity");
  assert.equal(shortNumber(1 / 3), "0.333333");
  assert.equal(shortNumber(3913030420.25), "3913030420");
  assert.equal(shortNumber(-16777219), "-16777219");
  assert.equal(shortNumber(0), "0");
  assert.deepEqual([0.8, 0.8, 1.25].map(shortNumber), ["0.8", "0.8", "1.25"]);
  assert.equal(shortNumber(1e300), "1e+300");
});

test("units of shaders are powers of two near a value, of what has no size 1", () => {
  assert.deepEqual(
    [80, 1, 1e-40, 3.4e38, 0, -5, NaN, Infinity].map(powerOfTwo),
    [64, 1, 2 ** -133, 2 ** 128, 1, 1, 1, 1],
  );
});

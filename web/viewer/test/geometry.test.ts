import assert from "node:assert/strict";
import test from "node:test";
import { type Geometry, type Vec3 } from "../src/reader/volume.js";
import {
  boxIn,
  levelForPixels,
  levelText,
  nearestWorldAxes,
  orientationOf,
  placeText,
  sampleAt,
  sideLetters,
  toIndex,
  toWorld,
} from "../src/view/geometry.js";

const straight: Geometry = {
  origin: [-10, 20, 30],
  spacing: [0.5, 0.75, 2],
  direction: [1, 0, 0, 0, 1, 0, 0, 0, 1],
};
const turned: Geometry = {
  origin: [5, -7, 11],
  spacing: [0.9, 1.1, 1.3],
  direction: [0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6],
};

test("a place in mm is that of the index, and back", () => {
  assert.deepEqual(toWorld(straight, [2, 4, 1]), [-9, 23, 32]);
  for (const g of [straight, turned]) {
    for (const index of [
      [0, 0, 0],
      [3.5, -2, 17],
      [100, 50, 25],
    ] as Vec3[]) {
      toIndex(g, toWorld(g, index)).forEach((v, a) => assert.ok(Math.abs(v - index[a]!) < 1e-9));
    }
  }
});

test("a place has the digits that tell a voxel from the next", () => {
  const facts = { geometry: straight, isPlaceKnown: true, isSpacingKnown: true };
  assert.equal(placeText(facts, [2, 4, 1]), "R 9.0, P 23.0, S 32.0 mm");
  const fine: Geometry = { ...straight, origin: [0, -1, 0], spacing: [0.0002, 0.0195, 0.1] };
  assert.equal(
    placeText({ ...facts, geometry: fine }, [20, 15, 3]),
    "L 0.0040, A 0.7075, S 0.3000 mm",
  );
  const nowhere = { ...facts, geometry: fine, isPlaceKnown: false };
  assert.equal(placeText(nowhere, [1, 0, 10]), "0.0002, -1.0000, 1.0000 mm");
  assert.equal(placeText({ ...nowhere, isSpacingKnown: false }, [1, 0, 10]), "");
});

test("slices of a straight grid are drawn as radiologists have them", () => {
  const axial = orientationOf(straight, 2);
  assert.deepEqual([axial.left, axial.right, axial.top, axial.bottom], ["R", "L", "A", "P"]);
  assert.deepEqual(
    [axial.across, axial.down, axial.flipsAcross, axial.flipsDown],
    [0, 1, false, false],
  );
  const coronal = orientationOf(straight, 1);
  assert.deepEqual([coronal.left, coronal.top, coronal.flipsDown], ["R", "S", true]);
  const sagittal = orientationOf(straight, 0);
  assert.deepEqual([sagittal.left, sagittal.right, sagittal.top], ["A", "P", "S"]);
  assert.deepEqual([axial.name, coronal.name, sagittal.name], ["axial", "coronal", "sagittal"]);
});

test("the neurological side mirrors axial and coronal slices, not sagittal ones", () => {
  const axial = orientationOf(straight, 2, false);
  assert.deepEqual([axial.left, axial.right, axial.flipsAcross], ["L", "R", true]);
  assert.deepEqual(orientationOf(straight, 0, false), orientationOf(straight, 0, true));
});

test("axes that run against the body are flipped, and permuted ones found", () => {
  const g: Geometry = { ...straight, direction: [0, 0, -1, -1, 0, 0, 0, 1, 0] };
  assert.deepEqual(
    nearestWorldAxes(g).map((w) => [w.axis, w.isNegative]),
    [
      [1, true],
      [2, false],
      [0, true],
    ],
  );
  const across = orientationOf(g, 2);
  assert.equal(across.name, "sagittal");
  assert.deepEqual([across.across, across.flipsAcross, across.left], [0, true, "A"]);
});

test("sides have more letters where the nearest is not clear", () => {
  assert.equal(sideLetters([0.1, -0.97, 0.2]), "A");
  assert.equal(sideLetters([0.695, 0.719, 0]), "PL");
  assert.equal(sideLetters([-0.6, -0.57, 0.56]), "RAS");
  const [c, s] = [Math.cos(0.77), Math.sin(0.77)];
  const turned = orientationOf({ ...straight, direction: [c, -s, 0, s, c, 0, 0, 0, 1] }, 1);
  const { left, right, top, bottom } = turned;
  assert.deepEqual([left, right, top, bottom], ["RA", "LP", "S", "I"]);
});

test("levels: samples over voxels, the one for a pixel, and its name", () => {
  const levels = [0, 1, 2].map((k) => ({
    size: [100 >> k, 90 >> k, 40] as Vec3,
    factor: [2 ** k, 2 ** k, 1] as Vec3,
  }));
  assert.equal(sampleAt(levels[2]!, 0, 99), 24);
  assert.equal(sampleAt(levels[1]!, 0, 7), 3);
  const axial = orientationOf(straight, 2);
  assert.equal(levelForPixels(levels, straight, axial, 0.6), 0);
  assert.equal(levelForPixels(levels, straight, axial, 1.6), 1);
  assert.equal(levelForPixels(levels, straight, axial, 100), 2);
  assert.equal(levelText(levels[2]!), "1/4");
});

test("a box among the voxels of another grid covers those that it meets, and no others", () => {
  const over: Geometry = { ...straight, origin: [-10, 20, 30], spacing: [1, 0.75, 2] };
  const to = (v: Vec3): Vec3 => toIndex(over, toWorld(straight, v));
  const size: Vec3 = [50, 90, 40];
  assert.deepEqual(boxIn({ lo: [0, 0, 0], hi: [100, 90, 40] }, to, size), {
    lo: [0, 0, 0],
    hi: size,
  });
  // Voxels 10 .. 19 reach from 4.75 to 9.75 in units of 1, whose voxel i reaches to i + 0.5.
  assert.deepEqual(boxIn({ lo: [10, 3, 5], hi: [20, 7, 6] }, to, size), {
    lo: [5, 3, 5],
    hi: [11, 7, 6],
  });
});

import assert from "node:assert/strict";
import test from "node:test";
import { type Geometry, type Vec3 } from "../src/reader/volume.js";
import { dot, raysOf, turnedCamera, viewAxes } from "../src/view/camera.js";

const g: Geometry = {
  origin: [-10, 20, 30],
  spacing: [1, 1, 2],
  direction: [1, 0, 0, 0, 1, 0, 0, 0, 1],
};

function near(a: Vec3, b: Vec3): void {
  a.forEach((v, i) => assert.ok(Math.abs(v - b[i]!) < 1e-9, `${a} is not ${b}`));
}

test("azimuth 0 looks from the front, 90 from the left; elevation 90 from above", () => {
  near(viewAxes({ azimuth: 0, elevation: 0, zoom: 1 }).toward, [0, -1, 0]);
  near(viewAxes({ azimuth: 0, elevation: 0, zoom: 1 }).right, [1, 0, 0]);
  near(viewAxes({ azimuth: 90, elevation: 0, zoom: 1 }).toward, [1, 0, 0]);
  near(viewAxes({ azimuth: 0, elevation: 90, zoom: 1 }).toward, [0, 0, 1]);
  const axes = viewAxes({ azimuth: 33, elevation: -21, zoom: 1 });
  for (const [u, v] of [
    [axes.up, axes.right],
    [axes.up, axes.toward],
  ] as const) {
    assert.ok(Math.abs(dot(u, v)) < 1e-9);
  }
});

test("rays of the middle pixel go through the middle, and the box fits", () => {
  const rays = raysOf(g, [100, 100, 50], { azimuth: 0, elevation: 0, zoom: 1 }, 200, 200);
  near(rays.middle, [49.5, 49.5, 24.5]);
  near(rays.forward, [0, 1, 0]);
  assert.ok(Math.abs(rays.pixelMm - 100 / 200 / 0.9) < 1e-9);
  near(rays.right, [rays.pixelMm, 0, 0]);
  near(rays.down, [0, 0, -rays.pixelMm / 2]);
  assert.equal(rays.reachMm, 50);
});

test("turning stays within its bounds", () => {
  const camera = turnedCamera({ azimuth: 170, elevation: 80, zoom: 2 }, -60, 100);
  assert.equal(camera.azimuth, -160);
  assert.equal(camera.elevation, 90);
});

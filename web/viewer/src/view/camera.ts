// A look at the volume along parallel rays, turned with the mouse.
import { AXES, type Geometry, type Vec3 } from "../reader/volume.js";
import { toIndex, toWorld } from "./geometry.js";

export interface Camera {
  /** Degrees: 0 is the front, 90 the patient's left. */
  readonly azimuth: number;
  /** Degrees: 90 is above the head. */
  readonly elevation: number;
  /** 1: the whole volume fits. */
  readonly zoom: number;
}

export const USUAL_CAMERA: Camera = { azimuth: 30, elevation: 20, zoom: 1 };

export interface ViewAxes {
  readonly toward: Vec3;
  readonly up: Vec3;
  readonly right: Vec3;
}

export function dot(a: Vec3, b: Vec3): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function cross(a: Vec3, b: Vec3): Vec3 {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export function plus(a: Vec3, b: Vec3, times = 1): Vec3 {
  return [a[0] + b[0] * times, a[1] + b[1] * times, a[2] + b[2] * times];
}

/** The viewer's axes in the patient's space, as `octavo render --azimuth --elevation` has them. */
export function viewAxes(camera: Camera): ViewAxes {
  const azimuth = (camera.azimuth * Math.PI) / 180;
  const elevation = (camera.elevation * Math.PI) / 180;
  const level = Math.cos(elevation);
  const rise = Math.sin(elevation);
  const toward: Vec3 = [Math.sin(azimuth) * level, -Math.cos(azimuth) * level, rise];
  const up: Vec3 = [-Math.sin(azimuth) * rise, Math.cos(azimuth) * rise, level];
  return { toward, up, right: cross(up, toward) };
}

export function turnedCamera(from: Camera, right: number, down: number): Camera {
  return {
    azimuth: ((((from.azimuth - right * 0.5) % 360) + 540) % 360) - 180,
    elevation: Math.max(-90, Math.min(90, from.elevation + down * 0.5)),
    zoom: from.zoom,
  };
}

/** The eight corners of a grid's box, in mm. */
export function corners(g: Geometry, size: Vec3): Vec3[] {
  return [0, 1, 2, 3, 4, 5, 6, 7].map((n) =>
    toWorld(g, AXES.map((a) => ((n >> a) & 1 ? size[a] - 0.5 : -0.5)) as unknown as Vec3),
  );
}

const FILLED_SHARE = 0.9;

export interface Rays {
  /** The index-space position of the middle of the picture, and steps of a pixel and of a mm. */
  readonly middle: Vec3;
  readonly right: Vec3;
  readonly down: Vec3;
  /** Away from the viewer, for one mm. */
  readonly forward: Vec3;
  readonly pixelMm: number;
  /** Half the depth of the box along the rays, mm. */
  readonly reachMm: number;
}

/** The rays of a picture in indices of level 0, whose voxel centers are whole numbers. */
export function raysOf(
  g: Geometry,
  size: Vec3,
  camera: Camera,
  width: number,
  height: number,
): Rays {
  const axes = viewAxes(camera);
  const middle = toWorld(g, AXES.map((a) => (size[a] - 1) / 2) as unknown as Vec3);
  let across = 0;
  let tall = 0;
  let reach = 0;
  for (const corner of corners(g, size)) {
    const from = plus(corner, middle, -1);
    across = Math.max(across, Math.abs(dot(from, axes.right)));
    tall = Math.max(tall, Math.abs(dot(from, axes.up)));
    reach = Math.max(reach, Math.abs(dot(from, axes.toward)));
  }
  const pixelMm =
    Math.max((2 * across) / width, (2 * tall) / height) / FILLED_SHARE / camera.zoom;
  const origin = toIndex(g, middle);
  const along = (direction: Vec3, mm: number): Vec3 =>
    plus(toIndex(g, plus(middle, direction, mm)), origin, -1);
  return {
    middle: origin,
    right: along(axes.right, pixelMm),
    down: along(axes.up, -pixelMm),
    forward: along(axes.toward, -1),
    pixelMm,
    reachMm: reach,
  };
}

// How a panel of so many pixels shows a slice, and how overlaid labels lie in it.
import { AXES, type Axis, type Geometry, type Vec3, type VolumeFacts } from "../reader/volume.js";
import { type SliceView } from "../store/state.js";
import { type Orientation, orientationOf, toIndex, toWorld } from "./geometry.js";
import { type SliceMap } from "./slice_painter.js";

export interface SliceLook {
  readonly map: SliceMap;
  /** Side of a pixel, mm (or the finest voxel's where the spacing is not known). */
  readonly pixelMm: number;
  /** Voxels of level 0 that are seen, along across and down. */
  readonly lo: readonly [number, number];
  readonly hi: readonly [number, number];
}

export function sliceLook(
  facts: VolumeFacts,
  o: Orientation,
  view: SliceView,
  width: number,
  height: number,
): SliceLook {
  const size = facts.levels[0]!.size;
  const spacing = facts.geometry.spacing;
  const fitting = Math.max(
    (size[o.across] * spacing[o.across]) / width,
    (size[o.down] * spacing[o.down]) / height,
  );
  const pixelMm = fitting / view.zoom;
  const center = view.center ?? [(size[o.across] - 1) / 2, (size[o.down] - 1) / 2];
  const step = [
    ((o.flipsAcross ? -1 : 1) * pixelMm) / spacing[o.across],
    ((o.flipsDown ? -1 : 1) * pixelMm) / spacing[o.down],
  ] as const;
  const first = [center[0] - (step[0] * width) / 2, center[1] - (step[1] * height) / 2] as const;
  const end = [center[0] + (step[0] * width) / 2, center[1] + (step[1] * height) / 2] as const;
  return {
    map: { first, step },
    pixelMm,
    lo: [Math.min(first[0], end[0]), Math.min(first[1], end[1])],
    hi: [Math.max(first[0], end[0]), Math.max(first[1], end[1])],
  };
}

/** Where a pixel lies: a fractional voxel of level 0 on the slice. */
export function voxelAtPixel(
  o: Orientation,
  map: SliceMap,
  slice: number,
  x: number,
  y: number,
): Vec3 {
  const at: [number, number, number] = [0, 0, 0];
  at[o.axis] = slice;
  at[o.across] = map.first[0] + x * map.step[0];
  at[o.down] = map.first[1] + y * map.step[1];
  return at;
}

export function pixelOfVoxel(o: Orientation, map: SliceMap, voxel: Vec3): [number, number] {
  return [
    (voxel[o.across] - map.first[0]) / map.step[0],
    (voxel[o.down] - map.first[1]) / map.step[1],
  ];
}

/** A grid whose axes are parallel to those of another one: which axis is which. */
export function parallelAxes(g: Geometry, other: Geometry): readonly Axis[] | undefined {
  const along = (of: Geometry, a: Axis): Vec3 => [
    of.direction[a]!,
    of.direction[3 + a]!,
    of.direction[6 + a]!,
  ];
  const found = AXES.map((a) =>
    AXES.find((b) => {
      const [u, v] = [along(g, a), along(other, b)];
      return Math.abs(u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) > 1 - 1e-6;
    }),
  );
  return found.every((axis) => axis !== undefined) ? (found as Axis[]) : undefined;
}

export interface OverlaySlice {
  readonly orientation: Orientation;
  readonly map: SliceMap;
  readonly slice: number;
}

/** The slice of an overlaid volume that lies in a slice of `facts`; undefined where it has none. */
export function overlaySlice(
  facts: VolumeFacts,
  o: Orientation,
  map: SliceMap,
  slice: number,
  over: VolumeFacts,
): OverlaySlice | undefined {
  const axes = parallelAxes(facts.geometry, over.geometry);
  if (!axes) return undefined;
  const place = (x: number, y: number): Vec3 =>
    toIndex(over.geometry, toWorld(facts.geometry, voxelAtPixel(o, map, slice, x, y)));
  const [corner, right, below] = [place(0, 0), place(1, 0), place(0, 1)];
  const [axis, across, down] = [axes[o.axis]!, axes[o.across]!, axes[o.down]!];
  const at = Math.round(corner[axis]);
  if (at < 0 || at >= over.levels[0]!.size[axis]) return undefined;
  const orientation = { ...orientationOf(over.geometry, axis), axis, across, down };
  return {
    orientation,
    map: {
      first: [corner[across], corner[down]],
      step: [right[across] - corner[across], below[down] - corner[down]],
    },
    slice: at,
  };
}

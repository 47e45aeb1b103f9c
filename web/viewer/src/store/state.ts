// What is shown and how: plain values that change one at a time, and who hears of it.
import { type Axis, type Box, type Vec3 } from "../reader/volume.js";
import { type Camera, USUAL_CAMERA } from "../view/camera.js";
import { type Measurement, type MeasureKind } from "../view/measure.js";
import { type Transfer } from "../view/transfer.js";
import { type Window } from "../view/window.js";
import { type Layout, type Mode } from "./permalink.js";

export type Tool = "cursor" | "window" | "pan" | MeasureKind;

/** Where a slice panel looks: the voxel in its middle, and how much larger than fitting. */
export interface SliceView {
  readonly center: readonly [number, number] | undefined;
  readonly zoom: number;
}

export interface ViewState {
  at: Vec3;
  window: Window;
  layout: Layout;
  mode: Mode;
  iso: number;
  transfer: Transfer;
  transferName: string;
  camera: Camera;
  clip: Box;
  tool: Tool;
  isNeurological: boolean;
  hasAnnotations: boolean;
  overlayOpacity: number;
  hiddenLabels: ReadonlySet<number>;
  measurements: readonly Measurement[];
  slices: Readonly<Record<Axis, SliceView>>;
}

export const FITTING: SliceView = { center: undefined, zoom: 1 };

export function emptyState(): ViewState {
  return {
    at: [0, 0, 0],
    window: { center: 0, width: 1 },
    layout: "four",
    mode: "volume",
    iso: 0,
    transfer: [],
    transferName: "auto",
    camera: USUAL_CAMERA,
    clip: { lo: [0, 0, 0], hi: [1, 1, 1] },
    tool: "cursor",
    isNeurological: false,
    hasAnnotations: true,
    overlayOpacity: 0.5,
    hiddenLabels: new Set(),
    measurements: [],
    slices: { 0: FITTING, 1: FITTING, 2: FITTING },
  };
}

export type StateKey = keyof ViewState;
export type Listener = (changed: ReadonlySet<StateKey>) => void;

export class Store {
  private state = emptyState();
  private readonly listeners: Listener[] = [];

  get now(): Readonly<ViewState> {
    return this.state;
  }

  set(change: Partial<ViewState>): void {
    const changed = new Set<StateKey>();
    for (const key of Object.keys(change) as StateKey[]) {
      if (this.state[key] !== change[key]) changed.add(key);
    }
    if (changed.size === 0) return;
    this.state = { ...this.state, ...change };
    for (const listener of this.listeners) listener(changed);
  }

  /** A view of a new volume; listeners hear of everything. */
  reset(state: ViewState): void {
    this.state = state;
    const all = new Set(Object.keys(state) as StateKey[]);
    for (const listener of this.listeners) listener(all);
  }

  listen(listener: Listener): void {
    this.listeners.push(listener);
  }
}

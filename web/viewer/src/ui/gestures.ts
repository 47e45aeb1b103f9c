// Mouse, pen, fingers and wheel on panels.
import { AXES, type Vec3, type VolumeFacts } from "../reader/volume.js";
import { type Store } from "../store/state.js";
import { turnedCamera } from "../view/camera.js";
import { clampVoxel } from "../view/geometry.js";
import { type MeasureKind, POINTS_NEEDED } from "../view/measure.js";
import { draggedWindow } from "../view/window.js";
import { type RayPanel } from "./ray_panel.js";
import { type SlicePanel } from "./slice_panel.js";

interface Finger {
  x: number;
  y: number;
}

export interface Hover {
  (voxel: Vec3 | undefined): void;
}

type Action = "cursor" | "window" | "pan" | MeasureKind;

/** What moves less than this is a click. */
const DRAG_PIXELS = 5;

export class SliceGestures {
  private readonly fingers = new Map<number, Finger>();
  private action: Action = "cursor";
  /** Where the button or finger went down. */
  private pressed: Finger = { x: 0, y: 0 };
  private wheelRest = 0;

  constructor(
    private readonly panel: SlicePanel,
    private readonly store: Store,
    private readonly facts: () => VolumeFacts | undefined,
    private readonly hover: Hover,
  ) {
    const e = panel.element.querySelector("canvas")!;
    e.addEventListener("pointerdown", (event) => this.down(event));
    e.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"] as const) {
      e.addEventListener(end, (event) => this.up(event));
    }
    e.addEventListener("pointerleave", () => this.hover(undefined));
    e.addEventListener("contextmenu", (event) => event.preventDefault());
    e.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    e.addEventListener("dblclick", () => {
      const view = { center: undefined, zoom: 1 };
      this.store.set({ slices: { ...this.store.now.slices, [this.panel.axis]: view } });
    });
  }

  private down(event: PointerEvent): void {
    if (!this.facts()) return;
    this.panel.element.focus({ preventScroll: true });
    (event.target as Element).setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.pressed = { x: event.clientX, y: event.clientY };
    if (this.fingers.size > 1) {
      this.action = "pan";
      return;
    }
    this.action =
      event.button === 2
        ? "window"
        : event.button === 1 || event.shiftKey
          ? "pan"
          : this.store.now.tool;
    const voxel = this.panel.voxelAt(event.clientX, event.clientY);
    if (this.action === "cursor") this.moveCursor(voxel);
    else if (this.action !== "window" && this.action !== "pan") this.addPoint(this.action, voxel);
  }

  private moveCursor(voxel: Vec3): void {
    this.store.set({ at: clampVoxel(this.facts()!.levels[0]!.size, voxel) });
  }

  /** Starts a measurement, or gives the one that is being drawn another point. */
  private addPoint(kind: MeasureKind, voxel: Vec3): void {
    const all = this.store.now.measurements;
    const last = all.at(-1);
    const { axis } = this.panel;
    const slice = this.store.now.at[axis];
    const isOpen =
      last &&
      last.kind === kind &&
      last.axis === axis &&
      last.slice === slice &&
      last.points.length < POINTS_NEEDED[kind];
    if (isOpen) {
      const grown = { ...last, points: [...last.points, voxel] };
      this.store.set({ measurements: [...all.slice(0, -1), grown] });
      return;
    }
    const whole = all.filter((m) => m.points.length >= POINTS_NEEDED[m.kind]);
    // The second point is dragged from the first.
    const points = kind === "angle" ? [voxel] : [voxel, voxel];
    this.store.set({ measurements: [...whole, { kind, axis, slice, points }] });
  }

  private dragPoint(voxel: Vec3, event: PointerEvent): void {
    const all = this.store.now.measurements;
    const last = all.at(-1);
    if (!last) return;
    let fixed = last.points.slice(0, -1);
    if (last.kind === "angle" && fixed.length === 0) {
      // The first leg of an angle may be dragged; a click that trembles is no drag.
      const { x, y } = this.pressed;
      if (Math.hypot(event.clientX - x, event.clientY - y) < DRAG_PIXELS) return;
      fixed = [...last.points];
    }
    const points = [...fixed, voxel];
    this.store.set({ measurements: [...all.slice(0, -1), { ...last, points }] });
  }

  private move(event: PointerEvent): void {
    const facts = this.facts();
    if (!facts) return;
    const before = this.fingers.get(event.pointerId);
    const voxel = this.panel.voxelAt(event.clientX, event.clientY);
    if (!before) {
      const size = facts.levels[0]!.size;
      const isIn = AXES.every((a) => voxel[a] >= -0.5 && voxel[a] < size[a] - 0.5);
      this.hover(isIn ? clampVoxel(size, voxel) : undefined);
      return;
    }
    const dx = event.clientX - before.x;
    const dy = event.clientY - before.y;
    if (this.fingers.size === 2) this.pinch(event, before);
    else if (this.action === "cursor") this.moveCursor(voxel);
    else if (this.action === "window") {
      this.store.set({ window: draggedWindow(this.store.now.window, dx, -dy) });
    } else if (this.action === "pan") {
      const ratio = window.devicePixelRatio || 1;
      this.panel.pan(dx * ratio, dy * ratio);
    } else this.dragPoint(voxel, event);
    before.x = event.clientX;
    before.y = event.clientY;
  }

  /** Two fingers: moves with their middle, zooms with their distance. */
  private pinch(event: PointerEvent, moved: Finger): void {
    const other = [...this.fingers.values()].find((finger) => finger !== moved)!;
    const length = (x: number, y: number): number => Math.hypot(x - other.x, y - other.y);
    const factor = length(event.clientX, event.clientY) / Math.max(1, length(moved.x, moved.y));
    const ratio = window.devicePixelRatio || 1;
    this.panel.pan(
      ((event.clientX - moved.x) / 2) * ratio,
      ((event.clientY - moved.y) / 2) * ratio,
    );
    const middle = this.panel.voxelAt(
      (event.clientX + other.x) / 2,
      (event.clientY + other.y) / 2,
    );
    this.panel.zoomAt(middle, factor);
  }

  private up(event: PointerEvent): void {
    this.fingers.delete(event.pointerId);
  }

  private wheel(event: WheelEvent): void {
    const facts = this.facts();
    if (!facts) return;
    event.preventDefault();
    const pixels = event.deltaMode === 0 ? event.deltaY : event.deltaY * 40;
    if (event.ctrlKey || event.metaKey) {
      const voxel = this.panel.voxelAt(event.clientX, event.clientY);
      this.panel.zoomAt(voxel, Math.exp(-pixels / 300));
      return;
    }
    this.wheelRest += pixels;
    const steps = Math.trunc(this.wheelRest / 40);
    if (steps === 0) return;
    this.wheelRest -= steps * 40;
    const at = [...this.store.now.at] as [number, number, number];
    at[this.panel.axis] += steps;
    this.store.set({ at: clampVoxel(facts.levels[0]!.size, at) });
  }
}

export class RayGestures {
  private readonly fingers = new Map<number, Finger>();

  constructor(
    panel: RayPanel,
    private readonly store: Store,
  ) {
    const e = panel.element.querySelector("canvas")!;
    e.addEventListener("pointerdown", (event) => {
      panel.element.focus({ preventScroll: true });
      e.setPointerCapture(event.pointerId);
      this.fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    e.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"] as const) {
      e.addEventListener(end, (event) => this.fingers.delete(event.pointerId));
    }
    e.addEventListener("contextmenu", (event) => event.preventDefault());
    e.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.zoom(Math.exp(-event.deltaY / 500));
      },
      { passive: false },
    );
  }

  private zoom(factor: number): void {
    const { camera } = this.store.now;
    const zoom = Math.max(0.25, Math.min(20, camera.zoom * factor));
    this.store.set({ camera: { ...camera, zoom } });
  }

  private move(event: PointerEvent): void {
    const before = this.fingers.get(event.pointerId);
    if (!before) return;
    if (this.fingers.size === 2) {
      const other = [...this.fingers.values()].find((finger) => finger !== before)!;
      const now = Math.hypot(event.clientX - other.x, event.clientY - other.y);
      this.zoom(now / Math.max(1, Math.hypot(before.x - other.x, before.y - other.y)));
    } else {
      const turned = turnedCamera(
        this.store.now.camera,
        event.clientX - before.x,
        event.clientY - before.y,
      );
      this.store.set({ camera: turned });
    }
    before.x = event.clientX;
    before.y = event.clientY;
  }
}

// Keys. Whatever the mouse does can be done without it.
import { type Axis, type VolumeFacts } from "../reader/volume.js";
import { type Store, type Tool, FITTING } from "../store/state.js";
import { LAYOUTS, MODES } from "../store/permalink.js";
import { USUAL_CAMERA, turnedCamera } from "../view/camera.js";
import { clampVoxel, orientationOf } from "../view/geometry.js";
import { WINDOW_PRESETS } from "../view/window.js";

export interface KeyActions {
  readonly help: () => void;
  readonly theme: () => void;
  readonly save: () => void;
  readonly autoWindow: () => void;
  readonly facts: () => VolumeFacts | undefined;
}

const TOOL_KEYS: Readonly<Record<string, Tool>> = {
  c: "cursor",
  w: "window",
  p: "pan",
  d: "distance",
  a: "angle",
  e: "roi",
};

/** The panel that has the focus: an axis, the 3-D view, or none. */
function focusedPanel(): Axis | "3d" | undefined {
  const id = (document.activeElement?.closest(".panel") as HTMLElement | null)?.id ?? "";
  const panels: Readonly<Record<string, Axis | "3d">> = {
    "panel-x": 0,
    "panel-y": 1,
    "panel-z": 2,
    "panel-3d": "3d",
  };
  return panels[id];
}

function moveCursor(
  store: Store,
  facts: VolumeFacts,
  axis: Axis,
  right: number,
  down: number,
  through: number,
): void {
  const o = orientationOf(facts.geometry, axis, !store.now.isNeurological);
  const at = [...store.now.at] as [number, number, number];
  at[o.across] += o.flipsAcross ? -right : right;
  at[o.down] += o.flipsDown ? -down : down;
  at[o.axis] += through;
  store.set({ at: clampVoxel(facts.levels[0]!.size, at) });
}

const ARROWS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

function onPanel(store: Store, facts: VolumeFacts, event: KeyboardEvent): boolean {
  const panel = focusedPanel();
  const { key } = event;
  const fast = event.shiftKey ? 10 : 1;
  const arrow = ARROWS[key];
  if (panel === "3d") {
    if (arrow) {
      store.set({ camera: turnedCamera(store.now.camera, arrow[0] * 10, arrow[1] * 10) });
      return true;
    }
    const factor = { "+": 1.2, "=": 1.2, "-": 1 / 1.2 }[key];
    if (!factor) return false;
    store.set({ camera: { ...store.now.camera, zoom: store.now.camera.zoom * factor } });
    return true;
  }
  if (panel === undefined) return false;
  if (arrow) {
    moveCursor(store, facts, panel, arrow[0] * fast, arrow[1] * fast, 0);
    return true;
  }
  const through = { PageUp: 1, PageDown: -1, "]": 1, "[": -1 }[key];
  if (through) {
    moveCursor(store, facts, panel, 0, 0, through * fast);
    return true;
  }
  const factor = { "+": 1.25, "=": 1.25, "-": 0.8 }[key];
  if (!factor) return false;
  const view = store.now.slices[panel];
  const zoom = Math.max(0.25, Math.min(200, view.zoom * factor));
  store.set({ slices: { ...store.now.slices, [panel]: { ...view, zoom } } });
  return true;
}

function anywhere(store: Store, actions: KeyActions, key: string): boolean {
  const tool = TOOL_KEYS[key];
  const preset = [...WINDOW_PRESETS.values()][Number(key) - 1];
  const state = store.now;
  if (tool) store.set({ tool });
  else if (key === "0") actions.autoWindow();
  else if (preset) store.set({ window: preset });
  else if (key === "l") {
    store.set({ layout: LAYOUTS[(LAYOUTS.indexOf(state.layout) + 1) % LAYOUTS.length]! });
  } else if (key === "m") {
    store.set({ mode: MODES[(MODES.indexOf(state.mode) + 1) % MODES.length]! });
  } else if (key === "n") store.set({ isNeurological: !state.isNeurological });
  else if (key === "o") store.set({ hasAnnotations: !state.hasAnnotations });
  else if (key === "r") {
    store.set({ slices: { 0: FITTING, 1: FITTING, 2: FITTING }, camera: USUAL_CAMERA });
  } else if (key === "Delete" || key === "Backspace") {
    store.set({ measurements: state.measurements.slice(0, -1) });
  } else if (key === "s") actions.save();
  else if (key === "t") actions.theme();
  else if (key === "?") actions.help();
  else return false;
  return true;
}

export function listenToKeys(store: Store, actions: KeyActions): void {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target as HTMLElement;
    if (target.closest("dialog[open]")) return;
    if (target.matches("input, select, textarea")) return;
    const facts = actions.facts();
    if ((facts && onPanel(store, facts, event)) || anywhere(store, actions, event.key)) {
      event.preventDefault();
    }
  });
}

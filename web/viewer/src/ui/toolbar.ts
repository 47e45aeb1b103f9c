// Buttons above the panels.
import { type Layout } from "../store/permalink.js";
import { type Store, TOOLS, type Tool } from "../store/state.js";
import { button, byId } from "./dom.js";

const TOOL_NAMES: Readonly<Record<Tool, readonly [string, string]>> = {
  cursor: ["Cursor", "Move the crosshair (c)"],
  window: ["Window", "Drag to change window and level (w); the right button always does"],
  pan: ["Move", "Move the picture (p)"],
  distance: ["Distance", "Measure a distance (d)"],
  angle: ["Angle", "Measure an angle: three clicks (a)"],
  roi: ["Region", "Statistics of a region (e)"],
};
const LAYOUT_NAMES: Readonly<Record<Layout, readonly [string, string]>> = {
  four: ["⊞", "All four views (l)"],
  z: ["z", "Slices across z alone"],
  y: ["y", "Slices across y alone"],
  x: ["x", "Slices across x alone"],
  "3d": ["3-D", "The 3-D view alone"],
};

export interface ToolbarActions {
  readonly choose: () => void;
  readonly save: () => void;
  readonly copyLink: () => void;
  readonly theme: () => void;
  readonly side: () => void;
  readonly help: () => void;
}

export function makeToolbar(store: Store, actions: ToolbarActions): void {
  const tools = TOOLS.map((tool) => {
    const [text, title] = TOOL_NAMES[tool];
    return [tool, button(text, title, () => store.set({ tool }))] as const;
  });
  byId("tools").append(...tools.map(([, made]) => made));
  const layouts = (["four", "z", "y", "x", "3d"] as const).map((layout) => {
    const [text, title] = LAYOUT_NAMES[layout];
    return [layout, button(text, title, () => store.set({ layout }))] as const;
  });
  const sides = button("L|R", "Neurological: the patient’s left on the left (n)", () =>
    store.set({ isNeurological: !store.now.isNeurological }),
  );
  byId("views").append(
    ...layouts.map(([, made]) => made),
    sides,
    button("Open", "Open another file, or labels to lay over this one", actions.choose),
    button("Link", "Copy a link to this view", actions.copyLink),
    button("PNG", "Save a picture (s)", actions.save),
    button("◐", "Dark or light (t)", actions.theme),
    button("☰", "Show or hide the settings", actions.side),
    button("?", "Help (?)", actions.help),
  );
  store.listen((changed) => {
    const state = store.now;
    if (changed.has("tool")) {
      for (const [tool, made] of tools)
        made.setAttribute("aria-pressed", String(tool === state.tool));
    }
    if (changed.has("layout")) {
      for (const [layout, made] of layouts) {
        made.setAttribute("aria-pressed", String(layout === state.layout));
      }
      byId("panels").dataset["layout"] = state.layout;
    }
    if (changed.has("isNeurological")) {
      sides.setAttribute("aria-pressed", String(state.isNeurological));
    }
  });
}

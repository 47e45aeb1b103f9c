// Buttons above the panels, which stand in the page.
import { type Layout } from "../store/permalink.js";
import { type Store, type Tool } from "../store/state.js";
import { byId } from "./dom.js";

export interface ToolbarActions {
  readonly choose: () => void;
  readonly save: () => void;
  readonly copyLink: () => void;
  readonly theme: () => void;
  readonly side: () => void;
  readonly help: () => void;
}

/** Those that have a word of one kind, and it. */
function buttons<T extends string>(kind: string): [HTMLElement, T][] {
  const all = document.querySelectorAll<HTMLElement>(`header [data-${kind}]`);
  return [...all].map((made) => [made, made.dataset[kind] as T]);
}

export function makeToolbar(store: Store, actions: ToolbarActions): void {
  const tools = buttons<Tool>("tool");
  for (const [made, tool] of tools) made.onclick = () => store.set({ tool });
  const layouts = buttons<Layout>("layout");
  for (const [made, layout] of layouts) made.onclick = () => store.set({ layout });
  for (const [made, act] of buttons<keyof ToolbarActions>("act")) made.onclick = actions[act];
  const sides = byId("sides");
  sides.onclick = () => store.set({ isNeurological: !store.now.isNeurological });
  const press = (made: HTMLElement, isPressed: boolean): void =>
    made.setAttribute("aria-pressed", String(isPressed));
  store.listen((changed) => {
    const state = store.now;
    if (changed.has("tool")) {
      for (const [made, tool] of tools) press(made, tool === state.tool);
    }
    if (changed.has("layout")) {
      for (const [made, layout] of layouts) press(made, layout === state.layout);
      byId("panels").dataset["layout"] = state.layout;
    }
    if (changed.has("isNeurological")) press(sides, state.isNeurological);
  });
}

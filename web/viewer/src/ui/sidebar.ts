// Settings as form elements: window, 3-D, clip box. Each follows the state and changes it.
import { type Vec3, type VolumeFacts, AXES } from "../reader/volume.js";
import { MODES, type Mode } from "../store/permalink.js";
import { type StateKey, type Store } from "../store/state.js";
import { TRANSFER_PRESETS, usualTransfer } from "../view/transfer.js";
import { WINDOW_PRESETS, roundedTo } from "../view/window.js";
import { byId, element } from "./dom.js";

const MODE_NAMES: Readonly<Record<Mode, string>> = {
  iso: "Surface",
  mip: "MIP",
  volume: "Volume",
};

export interface SidebarActions {
  readonly autoWindow: () => void;
  readonly facts: () => VolumeFacts | undefined;
}

function option(value: string, text: string): HTMLOptionElement {
  return element("option", { value }, text);
}

export class Sidebar {
  private readonly preset = byId<HTMLSelectElement>("preset");
  private readonly center = byId<HTMLInputElement>("center");
  private readonly width = byId<HTMLInputElement>("width");
  private readonly iso = byId<HTMLInputElement>("iso");
  private readonly isoSlider = byId<HTMLInputElement>("iso-slider");
  private readonly transferPreset = byId<HTMLSelectElement>("transfer-preset");
  private readonly modes = new Map<Mode, HTMLButtonElement>();
  private readonly clip: HTMLInputElement[] = [];

  constructor(
    private readonly store: Store,
    private readonly actions: SidebarActions,
  ) {
    this.makeWindow();
    this.makeModes();
    this.makeClip();
    store.listen((changed) => this.follow(changed));
  }

  private makeWindow(): void {
    this.preset.append(
      option("own", "own"),
      option("auto", "automatic"),
      ...[...WINDOW_PRESETS.keys()].map((name) => option(name, name)),
    );
    this.preset.addEventListener("change", () => {
      const window = WINDOW_PRESETS.get(this.preset.value);
      if (window) this.store.set({ window });
      else if (this.preset.value === "auto") this.actions.autoWindow();
    });
    const change = (): void => {
      const window = { center: this.center.valueAsNumber, width: this.width.valueAsNumber };
      if (Number.isFinite(window.center) && window.width > 0) this.store.set({ window });
      // A number is typed to its end: the fields show what it came to.
      this.center.value = String(this.store.now.window.center);
      this.width.value = String(this.store.now.window.width);
    };
    this.center.addEventListener("change", change);
    this.width.addEventListener("change", change);
  }

  private makeModes(): void {
    for (const mode of MODES) {
      const made = element("button", { type: "button", role: "radio" }, MODE_NAMES[mode]);
      made.addEventListener("click", () => this.store.set({ mode }));
      this.modes.set(mode, made);
      byId("modes").append(made);
    }
    this.iso.addEventListener("input", () => {
      const iso = Number(this.iso.value);
      if (this.iso.value !== "" && Number.isFinite(iso)) this.store.set({ iso });
    });
    this.isoSlider.addEventListener("input", () => {
      const { min, max, value } = this.isoSlider;
      this.store.set({ iso: roundedTo(Number(value), Number(max) - Number(min)) });
    });
    this.transferPreset.addEventListener("change", () => {
      const name = this.transferPreset.value;
      const transfer =
        TRANSFER_PRESETS.get(name) ??
        (name === "auto" ? usualTransfer(this.store.now.window) : undefined);
      if (transfer) this.store.set({ transfer, transferName: name });
    });
  }

  private makeClip(): void {
    for (const a of AXES) {
      byId("clip").append(element("span", {}, "xyz"[a]!));
      for (const end of ["lo", "hi"] as const) {
        const input = element("input", {
          type: "range",
          min: "0",
          "aria-label": `Clip ${"xyz"[a]}, ${end === "lo" ? "from" : "to"}`,
        });
        input.addEventListener("input", () => this.changeClip(a, end, Number(input.value)));
        this.clip.push(input);
        byId("clip").append(input);
      }
    }
  }

  private changeClip(axis: 0 | 1 | 2, end: "lo" | "hi", value: number): void {
    const { clip } = this.store.now;
    const ends = { lo: [...clip.lo] as number[], hi: [...clip.hi] as number[] };
    ends[end][axis] = value;
    if (ends.lo[axis]! >= ends.hi[axis]!) {
      if (end === "lo") ends.lo[axis] = ends.hi[axis]! - 1;
      else ends.hi[axis] = ends.lo[axis]! + 1;
    }
    this.store.set({ clip: { lo: ends.lo as unknown as Vec3, hi: ends.hi as unknown as Vec3 } });
  }

  /** What a new volume offers: presets in HU, the range of isovalues, the size of the clip box. */
  open(facts: VolumeFacts): void {
    const isGrey = facts.kind === "grey";
    const isHu = facts.unit === "HU";
    for (const choice of this.preset.options) {
      choice.hidden = WINDOW_PRESETS.has(choice.value) && facts.unit !== "" && !isHu;
    }
    this.transferPreset.replaceChildren(
      option("own", "own"),
      option("auto", "by the window"),
      ...(isHu || facts.unit === "" ? [...TRANSFER_PRESETS.keys()].map((n) => option(n, n)) : []),
    );
    byId("section-window").hidden = !isGrey;
    byId("modes").hidden = !isGrey;
    const real = facts.range.map((v) => v * facts.slope + facts.intercept).sort((a, b) => a - b);
    this.isoSlider.min = String(real[0]);
    this.isoSlider.max = String(real[1]);
    this.clip.forEach((input, i) => {
      input.max = String(facts.levels[0]!.size[Math.floor(i / 2) as 0]);
    });
  }

  private put(input: HTMLInputElement, text: string): void {
    if (document.activeElement !== input || input.type === "range") input.value = text;
  }

  private follow(changed: ReadonlySet<StateKey>): void {
    const state = this.store.now;
    const facts = this.actions.facts();
    if (changed.has("window")) {
      this.put(this.center, String(state.window.center));
      this.put(this.width, String(state.window.width));
      const preset = [...WINDOW_PRESETS].find(
        ([, w]) => w.center === state.window.center && w.width === state.window.width,
      );
      this.preset.value = preset?.[0] ?? "own";
    }
    if (changed.has("iso")) {
      this.put(this.iso, String(state.iso));
      this.put(this.isoSlider, String(state.iso));
    }
    if (changed.has("mode") || changed.has("transferName")) {
      const isGrey = facts?.kind !== "labels";
      for (const [mode, made] of this.modes) {
        made.setAttribute("aria-checked", String(mode === state.mode));
      }
      byId("iso-row").hidden = !isGrey || state.mode !== "iso";
      byId("transfer-row").hidden = !isGrey || state.mode !== "volume";
      this.transferPreset.value = state.transferName;
    }
    if (changed.has("clip")) {
      this.clip.forEach((input, i) => {
        const end = i % 2 === 0 ? state.clip.lo : state.clip.hi;
        input.value = String(end[Math.floor(i / 2) as 0]);
      });
    }
  }
}

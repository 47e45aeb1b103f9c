// Lists of the side: labels, measurements, facts of the file.
import { type Box, type VolumeFacts, type Vec3 } from "../reader/volume.js";
import { boxVoxels, cellBox, cellsOf } from "../decode/cells.js";
import { type Store } from "../store/state.js";
import { levelText, orientationOf } from "../view/geometry.js";
import { colorOf, nameOf } from "../view/label_color.js";
import {
  type Measurement,
  POINTS_NEEDED,
  RegionSums,
  type RoiStatistics,
  roiBox,
} from "../view/measure.js";
import { realText, statisticsText } from "../view/value_text.js";
import { shortNumber } from "../view/window.js";
import { button, byId, byteText, element, shownText } from "./dom.js";
import { measurementText } from "./measure_text.js";
import { type Session } from "./session.js";

/** Labels that are listed at once; more come as they are scrolled to. */
const LABELS_AT_ONCE = 200;

export class LabelList {
  private readonly list = byId("labels");
  private readonly find = byId<HTMLInputElement>("labels-find");
  private session: Session | undefined;
  /** Whether the labels of coarse voxels are among them. */
  private isWhole = false;
  private all: readonly number[] = [];
  private found: readonly number[] = [];

  constructor(private readonly store: Store) {
    byId("labels-all").addEventListener("click", () => this.hide(false));
    byId("labels-none").addEventListener("click", () => this.hide(true));
    this.find.addEventListener("input", () => this.search());
    this.list.addEventListener("scroll", () => {
      const { scrollTop, clientHeight, scrollHeight } = this.list;
      if (scrollTop + 2 * clientHeight > scrollHeight) this.draw();
    });
    const opacity = byId<HTMLInputElement>("opacity");
    opacity.addEventListener("input", () => store.set({ overlayOpacity: Number(opacity.value) }));
    store.listen((changed) => {
      if (changed.has("overlayOpacity")) opacity.value = String(store.now.overlayOpacity);
      if (changed.has("hiddenLabels")) this.check();
    });
  }

  /** The labels of a session; none hides the list. */
  open(session: Session | undefined, isOverlay: boolean): void {
    byId("section-labels").hidden = !session;
    byId("opacity-row").hidden = !isOverlay;
    this.session = session;
    this.isWhole = false;
    this.find.value = "";
    this.collect();
  }

  /** Cells are here: once, those that show which labels there are. */
  arrived(): void {
    if (!this.isWhole && this.session?.hasPreview) this.collect();
  }

  private collect(): void {
    const { session } = this;
    if (!session) return;
    this.isWhole = session.hasPreview;
    const numbers = new Set([...session.facts.labels.keys(), ...session.labelsSeen().keys()]);
    numbers.delete(0);
    this.all = [...numbers].sort((a, b) => a - b);
    this.search();
  }

  /** Lists the labels that have what is typed in their name or number. */
  private search(): void {
    const { labels } = this.session!.facts;
    const part = this.find.value.trim().toLowerCase();
    this.found = this.all.filter((n) => `${n} ${nameOf(labels, n)}`.toLowerCase().includes(part));
    byId("labels-count").textContent = `${this.found.length} of ${this.all.length}`;
    this.list.replaceChildren();
    this.draw();
  }

  /** Lists some more of what was found. */
  private draw(): void {
    const { facts } = this.session!;
    const drawn = this.list.childElementCount;
    const next = this.found.slice(drawn, drawn + LABELS_AT_ONCE);
    this.list.append(...next.map((n) => this.row(facts, n)));
    this.check();
  }

  /** Hides what was found, or shows it; all where nothing is searched. */
  private hide(isHidden: boolean): void {
    const isAll = this.found.length === this.all.length;
    const hidden = new Set(isAll ? [] : this.store.now.hiddenLabels);
    for (const n of this.found) isHidden ? hidden.add(n) : hidden.delete(n);
    this.store.set({ hiddenLabels: hidden });
  }

  /** Hides all labels but one; where that is so, shows all. */
  private showAlone(label: number): void {
    const others = this.all.filter((n) => n !== label);
    const hidden = this.store.now.hiddenLabels;
    const isAlone = !hidden.has(label) && others.every((n) => hidden.has(n));
    this.store.set({ hiddenLabels: new Set(isAlone ? [] : others) });
  }

  private row(facts: VolumeFacts, label: number): HTMLElement {
    const box = element("input", { type: "checkbox", "data-label": String(label) });
    box.addEventListener("change", () => {
      const hidden = new Set(this.store.now.hiddenLabels);
      if (box.checked) hidden.delete(label);
      else hidden.add(label);
      this.store.set({ hiddenLabels: hidden });
    });
    const swatch = element("span", { class: "swatch" });
    // Through the style object, which a policy without inline styles allows.
    swatch.style.backgroundColor = `rgb(${colorOf(facts.labels, label).join(",")})`;
    const name = shownText(nameOf(facts.labels, label), 80);
    box.setAttribute("aria-label", `Show ${name}`);
    return element(
      "li",
      {},
      box,
      swatch,
      element("span", {}, name),
      element("span", { class: "faint" }, String(label)),
      button("only", `Show ${name} alone, or all again`, () => this.showAlone(label)),
    );
  }

  private check(): void {
    const hidden = this.store.now.hiddenLabels;
    for (const box of this.list.querySelectorAll("input")) {
      box.checked = !hidden.has(Number(box.dataset["label"]));
    }
  }
}

/** A region larger than that is measured at a coarser level. */
const MOST_ROI_SAMPLES = 1 << 24;

/** What was found in a region, so that cells which come later do not have it measured again. */
interface Measured {
  readonly session: Session;
  readonly level: number;
  readonly text: string;
}

export class MeasureList {
  private readonly list = byId("measurements");
  private readonly measured = new WeakMap<Measurement, Measured>();
  /** How often voxels of a region were added up. */
  regionsMeasured = 0;

  constructor(
    private readonly store: Store,
    private readonly session: () => Session | undefined,
  ) {}

  /** Reads what regions need, coarse levels for want of room. */
  want(): void {
    const session = this.session();
    if (!session) return;
    const steps = this.regions().map((m) => {
      const level = this.roiLevel(session, m);
      return { level, cells: cellsOf(level, this.boxOf(session, m, level)) };
    });
    session.cells.want("roi", steps);
  }

  private regions(): Measurement[] {
    return this.store.now.measurements.filter((m) => m.kind === "roi" && m.points.length === 2);
  }

  private boxOf(session: Session, m: Measurement, level: number): ReturnType<typeof roiBox> {
    const o = orientationOf(session.facts.geometry, m.axis);
    return roiBox(session.facts.levels[level]!, o, m.slice, m.points);
  }

  private roiLevel(session: Session, m: Measurement): number {
    let level = 0;
    while (
      level < session.preview &&
      boxVoxels(this.boxOf(session, m, level)) > MOST_ROI_SAMPLES
    ) {
      level += 1;
    }
    return level;
  }

  /** The statistics of a region at the finest level that is here, and that level. */
  private roiText(session: Session, m: Measurement): string {
    const { facts, cells } = session;
    const before = this.measured.get(m);
    const known = before?.session === session ? before : undefined;
    for (let level = this.roiLevel(session, m); level <= session.preview; ++level) {
      if (known && known.level <= level) return known.text;
      const box = this.boxOf(session, m, level);
      if (!cells.hasAll({ level, cells: cellsOf(level, box) })) continue;
      const found = this.sums(session, box, level);
      const of = level === 0 ? "" : ` (of ${levelText(facts.levels[level]!)}, not yet the scan)`;
      const text = statisticsText(found, facts, facts.unit) + of;
      this.measured.set(m, { session, level, text });
      return text;
    }
    return known?.text ?? "reading …";
  }

  private sums(session: Session, box: Box, level: number): RoiStatistics {
    const { facts, cells } = session;
    const sums = new RegionSums(facts.slope, facts.intercept);
    for (const cell of cellsOf(level, box)) {
      const from = cellBox(facts.levels[level]!, cell.at);
      sums.add(cells.peek(cell)!, from, {
        lo: from.lo.map((v, a) => Math.max(v, box.lo[a as 0])) as unknown as Vec3,
        hi: from.hi.map((v, a) => Math.min(v, box.hi[a as 0])) as unknown as Vec3,
      });
    }
    this.regionsMeasured += 1;
    return sums.statistics;
  }

  draw(): void {
    const session = this.session();
    const all = this.store.now.measurements;
    byId("measure-hint").hidden = all.length > 0;
    if (!session) return;
    this.list.replaceChildren(
      ...all.map((m, i) => {
        const isWhole = m.points.length >= POINTS_NEEDED[m.kind];
        const text =
          m.kind !== "roi"
            ? measurementText(session.facts, m)
            : isWhole && session.facts.kind === "grey"
              ? this.roiText(session, m)
              : "";
        return element(
          "li",
          {},
          element(
            "span",
            {},
            `${m.kind === "roi" ? "region" : m.kind} ${"xyz"[m.axis]} ${m.slice}: ${text || "…"}`,
          ),
          button("✕", "Remove this measurement", () =>
            this.store.set({
              measurements: this.store.now.measurements.filter((_, j) => j !== i),
            }),
          ),
        );
      }),
    );
  }
}

/** What is known of the file, as text. */
export function showFacts(session: Session): void {
  const f = session.facts;
  const n = shortNumber;
  const rows: [string, string][] = [
    ["name", shownText(f.name)],
    [
      "holds",
      f.kind === "labels"
        ? "labels"
        : `grey values${f.unit === "" ? "" : `, ${shownText(f.unit, 30)}`}`,
    ],
    ["voxels", `${f.levels[0]!.size.join(" × ")}, ${f.type}`],
    ["spacing", f.isSpacingKnown ? `${f.geometry.spacing.map(n).join(" × ")} mm` : "not known"],
    ["levels", String(f.levels.length)],
    ["file", byteText(f.fileBytes)],
    ["values", f.range.map((v) => realText(f, v * f.slope + f.intercept)).join(" to ")],
    ["max. error", f.maxError === 0 ? "none, lossless" : n(f.maxError * Math.abs(f.slope))],
  ];
  if (session.volume.hostNote !== "")
    rows.push(["host", shownText(session.volume.hostNote, 300)]);
  byId("facts").replaceChildren(
    ...rows.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]),
  );
}

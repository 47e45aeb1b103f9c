// The viewer: opens volumes, joins panels and settings to the state, and says how true the picture
// is.
import {
  AXES,
  type Box,
  type SlowServer,
  type Traffic,
  type Vec3,
  type Volume,
} from "../reader/volume.js";
import {
  type Permalink,
  parsePermalink,
  permalinkText,
  rejectedAddresses,
} from "../store/permalink.js";
import { type StateKey, Store, type ViewState, emptyState } from "../store/state.js";
import { usualTransfer, TRANSFER_PRESETS } from "../view/transfer.js";
import { realText } from "../view/value_text.js";
import { clampVoxel, orientationOf } from "../view/geometry.js";
import { parallelAxes } from "../view/slice_look.js";
import { byId, shownText } from "./dom.js";
import { FailureDesk } from "./failure_desk.js";
import { Fidelity, openingText, showSlow } from "./fidelity.js";
import { RayGestures, SliceGestures } from "./gestures.js";
import { listenToKeys } from "./keyboard.js";
import { LabelList, MeasureList, showFacts } from "./lists.js";
import { Messages } from "./messages.js";
import { listedFiles, listenToDoors, nameOf, showList } from "./doors.js";
import { RayPanel } from "./ray_panel.js";
import { Readout } from "./readout.js";
import { Session } from "./session.js";
import { Sidebar } from "./sidebar.js";
import { SlicePanel } from "./slice_panel.js";
import { Stage } from "./stage.js";
import { switchTheme } from "./theme.js";
import { makeToolbar } from "./toolbar.js";
import { TransferEditor } from "./transfer_editor.js";

/** A link's clip box in a volume, each end at the nearest that there is; all of it without. */
function clippedTo(size: Vec3, clip: Box | undefined): Box {
  const lo = clip ? clampVoxel(size, clip.lo) : ([0, 0, 0] as const);
  const hi = size.map((n, a) => Math.max(lo[a as 0] + 1, Math.min(n, clip?.hi[a as 0] ?? n)));
  return { lo, hi: hi as unknown as Vec3 };
}

/** Opens a URL or a file, tells of a server while it is slow; rejects with a ReadFailure. */
export type Opener = (
  source: string | File,
  onSlow: (slow: SlowServer | null) => void,
) => Promise<Volume>;

/** Files of this machine have none. */
function urlOf(source: string | File): string | undefined {
  return typeof source === "string" ? source : undefined;
}

/** Decoded voxels that are kept: a quarter of what the browser says the machine has, at most. */
function cellBudget(): number {
  const gigabytes = (navigator as { deviceMemory?: number }).deviceMemory ?? 4;
  return Math.min(512, Math.max(96, gigabytes * 64)) * 2 ** 20;
}

export class App {
  readonly store = new Store();
  readonly stage: Stage;
  readonly slices: readonly SlicePanel[];
  readonly rays: RayPanel;
  session: Session | undefined;
  overlay: Session | undefined;
  private readonly messages = new Messages();
  private readonly desk = new FailureDesk(this.messages);
  private readonly fidelity = new Fidelity(
    () => this.session,
    () => this.overlay,
  );
  private readonly readout: Readout;
  private readonly labels: LabelList;
  readonly measures: MeasureList;
  private readonly transfer: TransferEditor;
  private readonly sidebar: Sidebar;
  private link: Permalink = {};
  private urls: { scan?: string; labels?: string } = {};
  private isFirstPicture = false;
  /** How often something was to be opened, and of which of these times scan and labels are. */
  private openings = 0;
  private scanOpening = 0;
  private labelsOpening = 0;
  /** What the first picture took. */
  firstTraffic: Traffic | undefined;
  private wantTimer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly opener: Opener) {
    const store = this.store;
    const ask = (): void => this.stage?.ask();
    this.slices = AXES.map((axis) => new SlicePanel(axis, store, ask));
    this.rays = new RayPanel(store, ask);
    this.stage = new Stage(
      this.slices,
      this.rays,
      (text) => this.messages.show(text, "error"),
      (text) => this.messages.clear(text),
      () => this.drawn(),
    );
    this.readout = new Readout(
      store,
      () => this.session,
      () => this.overlay,
    );
    this.labels = new LabelList(store);
    this.measures = new MeasureList(store, () => this.session);
    this.transfer = new TransferEditor(
      store,
      (span, bins) => this.session?.histogram(span, bins) ?? new Float64Array(bins),
    );
    this.sidebar = new Sidebar(store, {
      autoWindow: () => this.autoWindow(),
      facts: () => this.session?.facts,
    });
    // Where there is little room it belongs to the picture.
    document.body.classList.toggle("no-side", matchMedia("(max-width: 760px)").matches);
    this.join();
  }

  private join(): void {
    const facts = (): Session["facts"] | undefined => this.session?.facts;
    for (const panel of this.slices) {
      new SliceGestures(panel, this.store, facts, (voxel) => this.readout.hover(voxel));
    }
    new RayGestures(this.rays, this.store);
    const doors = listenToDoors((source, others = 0) => {
      void this.open(source);
      const all = `${others + 1} files at once`;
      if (others > 0) this.messages.show(`${all}: ${nameOf(source)} alone is opened`, "note");
    });
    const save = (): void => void this.save();
    makeToolbar(this.store, {
      choose: doors.choose,
      save,
      copyLink: () => void this.copyLink(),
      theme: () => this.theme(),
      side: () => {
        document.body.classList.toggle("no-side");
        this.wantSoon();
      },
      help: () => byId<HTMLDialogElement>("help").showModal(),
    });
    listenToKeys(this.store, {
      help: () => byId<HTMLDialogElement>("help").showModal(),
      theme: () => this.theme(),
      save,
      autoWindow: () => this.autoWindow(),
      facts,
    });
    new ResizeObserver(() => this.wantSoon()).observe(byId("panels"));
    this.store.listen((changed) => this.follow(changed));
    this.store.reset(emptyState());
  }

  /** Opens what the address of the page names, if it names anything. */
  async start(search: string): Promise<void> {
    const wrong: string[] = [];
    this.link = parsePermalink(search, document.baseURI, wrong);
    const rejected = rejectedAddresses(search, document.baseURI);
    const listed = this.link.url ? [] : await listedFiles();
    // Never another scan than the one that a link names.
    if (listed.length === 1 && !rejected.has("url")) this.link.url = listed[0]!.url;
    else showList(listed, (url) => void this.open(url));
    if (this.link.url) await this.open(this.link.url);
    if (this.link.labels && this.session) await this.openLabels(this.link.labels);
    if (wrong.length > 0) this.messages.add(`not understood in this link: ${wrong.join("; ")}`);
    for (const sentence of rejected.values()) this.messages.add(sentence);
  }

  /** Opens a volume, or what took the place of that of a session; the line says so until it is
   *  here. */
  private async bring(source: string | File, replaced?: Session): Promise<Volume> {
    const opening = openingText(nameOf(source));
    this.fidelity.opening = opening;
    this.drawn();
    try {
      return await (replaced ? replaced.volume.reopen() : this.opener(source, showSlow));
    } finally {
      if (this.fidelity.opening === opening) this.fidelity.opening = "";
    }
  }

  /** Labels that a link lays over its scan; anything else leaves the scan as it is. */
  private async openLabels(url: string): Promise<void> {
    const opening = this.scanOpening;
    try {
      const volume = await this.bring(url);
      const { kind, name } = volume.facts;
      if (opening < this.labelsOpening) volume.close();
      else if (kind === "labels" && this.session?.facts.kind === "grey")
        this.openOverlay(volume, url);
      else {
        volume.close();
        const why = kind === "grey" ? "holds no labels" : "labels lie over grey values alone";
        this.messages.show(`${name}: ${why}; it is not laid over the scan`, "error");
      }
    } catch (error) {
      if (opening === this.openings)
        this.desk.couldNotOpen(error, () => void this.openLabels(url));
    }
    this.drawn();
  }

  /** Opens a scan; or labels over the one that is there, unless its file was replaced by them. */
  async open(source: string | File, replaced?: Session): Promise<void> {
    const opening = ++this.openings;
    this.messages.clear();
    try {
      const volume = await this.bring(source, replaced);
      const scan = this.session;
      const isOverlay =
        scan?.facts.kind === "grey" && volume.facts.kind === "labels" && scan !== replaced;
      if (opening < (isOverlay ? this.labelsOpening : this.scanOpening)) volume.close();
      else {
        this.labelsOpening = opening;
        if (isOverlay) this.openOverlay(volume, source);
        else {
          this.scanOpening = opening;
          this.openScan(volume, source);
        }
      }
    } catch (error) {
      // A file of this machine is what it was.
      const isLost = typeof source !== "string" && !replaced;
      const again = isLost ? undefined : () => void this.open(source, replaced);
      if (opening === this.openings) this.desk.couldNotOpen(error, again);
    }
    this.drawn();
  }

  private newSession(volume: Volume, source: string | File): Session {
    const session: Session = new Session(
      volume,
      cellBudget(),
      () => this.arrived(session),
      (error) => this.desk.couldNotRead(error, session, () => void this.open(source, session)),
    );
    return session;
  }

  private end(session: Session | undefined): void {
    session?.close();
    this.desk.forget(session);
  }

  private openScan(volume: Volume, source: string | File): void {
    const url = urlOf(source);
    this.end(this.session);
    this.end(this.overlay);
    this.overlay = undefined;
    if (this.link.url !== url) this.rename(url ? { url } : {});
    const { link } = this;
    this.urls = url === undefined ? {} : { scan: url };
    this.session = this.newSession(volume, source);
    this.isFirstPicture = true;
    this.firstTraffic = undefined;
    const { facts } = this.session;
    byId("welcome").hidden = true;
    byId("title").textContent = shownText(facts.name, 80);
    document.title = `${shownText(facts.name, 80)} · Octavo`;
    this.sidebar.open(facts);
    const { size } = facts.levels[0]!;
    const window = link.window ?? this.session.autoWindow();
    this.store.reset({
      ...emptyState(),
      at: clampVoxel(size, link.at ?? (size.map((n) => Math.floor(n / 2)) as never)),
      window,
      tool: this.store.now.tool,
      hasAnnotations: this.store.now.hasAnnotations,
      layout: link.layout ?? this.store.now.layout,
      mode: link.mode ?? "volume",
      iso: link.iso ?? (facts.unit === "HU" ? 226 : window.center),
      ...this.curveOf(link, window, facts.unit),
      camera: link.camera ?? this.store.now.camera,
      clip: clippedTo(size, link.clip),
      hiddenLabels: (facts.kind === "labels" && link.hidden) || new Set(),
      isNeurological: link.isNeurological ?? false,
      overlayOpacity: link.opacity ?? 0.5,
    });
    for (const panel of this.slices) panel.open(this.session, undefined);
    this.rays.open(this.session);
    this.labels.open(facts.kind === "labels" ? this.session : undefined, false);
    showFacts(this.session);
    const [low, high] = facts.range;
    const real = realText(facts, low * facts.slope + facts.intercept);
    if (this.session.volume.hostNote !== "") {
      this.messages.show(this.session.volume.hostNote, "note");
    } else if (facts.kind === "grey" && low === high) {
      this.messages.show(`All voxels of ${facts.name} have the value ${real}.`, "note");
    }
    void this.show(this.session);
    this.stage.ask();
  }

  /** One coarse slice, then all of the volume as coarse, then what the panels show. */
  private async show(session: Session): Promise<void> {
    const { layout, at } = this.store.now;
    const axis = layout === "x" ? 0 : layout === "y" ? 1 : 2;
    await session.readFirst(orientationOf(session.facts.geometry, axis), at[axis]);
    if (session !== this.session) return;
    if (session.first) {
      this.firstTraffic = session.volume.traffic();
      if (!this.link.window) this.autoWindow();
      this.stage.draw();
    }
    session.wantPreview();
  }

  private openOverlay(volume: Volume, source: string | File): void {
    const url = urlOf(source);
    const scan = this.session!;
    if (!parallelAxes(scan.facts.geometry, volume.facts.geometry)) {
      this.messages.show(
        `${volume.facts.name}: its grid lies oblique to that of the scan`,
        "error",
      );
      volume.close();
      return;
    }
    this.end(this.overlay);
    this.overlay = this.newSession(volume, source);
    if (url === undefined) delete this.urls.labels;
    else this.urls.labels = url;
    if (this.link.labels !== url) {
      const { labels, hidden, ...rest } = this.link;
      this.rename(url ? { ...rest, labels: url } : rest);
    }
    this.store.set({ hiddenLabels: (url && this.link.hidden) || new Set() });
    for (const panel of this.slices) panel.open(scan, this.overlay);
    this.rays.openOverlay(this.overlay);
    this.labels.open(this.overlay, true);
    this.overlay.wantPreview();
    this.wantSoon();
  }

  /** Cells of a session are here. */
  private arrived(session: Session): void {
    if (session !== this.session && session !== this.overlay) return;
    if (session === this.session && this.isFirstPicture && session.hasPreview)
      this.firstPicture();
    if (session === this.overlay) this.labels.arrived();
    for (const panel of this.slices) panel.repaint();
    this.rays.arrived();
    this.measures.draw();
    this.readout.draw();
    this.stage.ask();
  }

  /** The first picture is here: window and colors follow what it shows. */
  private firstPicture(): void {
    this.isFirstPicture = false;
    const session = this.session!;
    this.firstTraffic ??= session.volume.traffic();
    if (!this.link.window) this.autoWindow();
    this.store.set(this.curveOf(this.link, this.store.now.window, session.facts.unit));
    this.labels.arrived();
    if (session.isNowhereFinite && !session.volume.hostNote)
      this.messages.show(`All voxels of ${session.facts.name} are NaN or infinite.`, "note");
    // Finer levels are asked for once the first picture is on the screen.
    requestAnimationFrame(() => this.want());
  }

  /** What is open is not, or no longer, what the address names. */
  private rename(link: Permalink): void {
    this.link = link;
    history.replaceState(null, "", this.addressOf(link));
  }

  private addressOf(link: Permalink): string {
    const query = permalinkText(link, document.baseURI, location.search);
    return /[^?#]*/.exec(location.href)! + query + location.hash;
  }

  /** The curve of a link, else one that suits the unit and the window. */
  private curveOf(
    link: Permalink,
    window: ViewState["window"],
    unit: string,
  ): Pick<ViewState, "transfer" | "transferName"> {
    const curve = link.curve ?? (unit === "HU" ? "bone" : "auto");
    if (typeof curve !== "string") return { transfer: curve, transferName: "own" };
    const preset = TRANSFER_PRESETS.get(curve);
    return { transfer: preset ?? usualTransfer(window), transferName: preset ? curve : "auto" };
  }

  private autoWindow(): void {
    const session = this.session;
    if (session?.facts.kind === "grey") this.store.set({ window: session.autoWindow() });
  }

  /** Asks for what the panels show, once things have come to rest for a moment. */
  private wantSoon(): void {
    clearTimeout(this.wantTimer);
    this.wantTimer = setTimeout(() => this.want(), 60);
    this.stage.ask();
  }

  private want(): void {
    for (const panel of this.slices) panel.want();
    this.rays.want();
    this.measures.want();
    this.readout.want();
    this.drawn();
    this.stage.ask();
  }

  private follow(changed: ReadonlySet<StateKey>): void {
    const any = (...keys: StateKey[]): boolean => keys.some((key) => changed.has(key));
    if (any("at", "layout", "slices", "isNeurological")) this.wantSoon();
    if (any("mode", "iso", "transfer", "clip", "camera", "hiddenLabels", "overlayOpacity")) {
      this.rays.moved();
      this.wantSoon();
    } else if (any("window") && this.store.now.mode === "mip") this.rays.moved();
    if (any("hiddenLabels")) for (const panel of this.slices) panel.repaint();
    if (any("transfer", "mode", "layout")) this.transfer.draw();
    if (any("measurements")) {
      this.measures.draw();
      this.wantSoon();
    }
    if (any("at")) this.readout.draw();
    this.stage.ask();
  }

  private drawn(): void {
    this.fidelity.update(this.slices, this.rays);
  }

  private theme(): void {
    switchTheme();
    this.transfer.draw();
    this.stage.ask();
  }

  /** The address of what is seen. Files of this machine have none. */
  permalink(): string {
    const s = this.store.now;
    const link: Permalink = {
      at: s.at,
      window: s.window,
      layout: s.layout,
      mode: s.mode,
      camera: s.camera,
      isNeurological: s.isNeurological,
    };
    if (s.mode === "iso") link.iso = s.iso;
    if (s.mode === "volume") link.curve = s.transferName === "own" ? s.transfer : s.transferName;
    const size = this.session?.facts.levels[0]!.size;
    if (size && AXES.some((a) => s.clip.lo[a] > 0 || s.clip.hi[a] < size[a])) link.clip = s.clip;
    if (this.urls.labels || this.session?.facts.kind === "labels") link.hidden = s.hiddenLabels;
    if (this.urls.scan) link.url = this.urls.scan;
    if (this.urls.labels) {
      link.labels = this.urls.labels;
      link.opacity = s.overlayOpacity;
    }
    return this.addressOf(link);
  }

  private async copyLink(): Promise<void> {
    const link = this.permalink();
    history.replaceState(null, "", link);
    if (!this.urls.scan) {
      this.messages.show("A file of this machine has no address that others could open.", "note");
      return;
    }
    try {
      await navigator.clipboard.writeText(link);
      this.messages.show("The link is copied; it stands in the address bar, too.", "note");
    } catch {
      this.messages.show("The link stands in the address bar.", "note");
    }
  }

  private async save(): Promise<void> {
    if (!this.session) return;
    const url = URL.createObjectURL(await this.stage.picture());
    const name = this.session.facts.name
      .split(/[/\\]/)
      .at(-1)!
      .replace(/[^\p{L}\p{M}\p{N}.-]+/gu, "_");
    const anchor = document.createElement("a");
    anchor.href = url;
    anchor.download = `${name || "octavo"}.png`;
    anchor.click();
    setTimeout(() => URL.revokeObjectURL(url), 10_000);
  }
}

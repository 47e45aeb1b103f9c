// How true the picture is, in words and numbers: "1/4 shown; 3.1 of 12 MB".
import { type SlowServer } from "../reader/volume.js";
import { levelText } from "../view/geometry.js";
import { byId, byteText, shownText } from "./dom.js";
import { type RayPanel } from "./ray_panel.js";
import { type Session } from "./session.js";
import { type SlicePanel } from "./slice_panel.js";

const EVERY_MS = 250;

/** "the server is slow: 12.0 kB of 65.5 kB after 8 s", with a button beside it. */
export function showSlow(slow: SlowServer | null): void {
  const line = byId("slow");
  line.hidden = !slow;
  if (!slow) return;
  const { arrivedBytes, wantedBytes, seconds } = slow;
  const wanted = wantedBytes > 0 ? ` of ${byteText(wantedBytes)}` : "";
  byId("slow-count").textContent = `${byteText(arrivedBytes)}${wanted} after ${seconds} s`;
  byId("slow-again").onclick = () => slow.askAgain();
}

/** "opening head.8vo …" */
export function openingText(name: string): string {
  return `opening ${shownText(name, 80)} …`;
}

export class Fidelity {
  private readonly line = byId("fidelity");
  private readonly traffic = byId("traffic");
  private missingBytes = 0;
  private isCounting = false;
  private countedAt = 0;
  private again: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly session: () => Session | undefined,
    private readonly overlay: () => Session | undefined,
  ) {}

  /** What is being opened, or nothing. */
  opening = "";

  private say(text: string, kind = ""): void {
    this.line.className = kind;
    if (this.line.textContent !== text) this.line.textContent = text;
  }

  /** The coarsest of what the panels show. */
  update(slices: readonly SlicePanel[], rays: RayPanel): void {
    const session = this.session();
    if (!session) {
      this.say(this.opening);
      byId("welcome-title").textContent = this.opening || "Open a scan";
      return;
    }
    const { bytes, requests } = session.volume.traffic();
    const counted = requests === 1 ? "1 request" : `${requests} requests`;
    this.traffic.textContent = `${counted}, ${byteText(bytes)}`;
    if (!session.hasPreview) {
      const level = session.facts.levels[session.preview]!;
      const text = session.first
        ? `${levelText(level)} shown`
        : openingText(session.facts.name);
      this.say(`${text}; ${byteText(bytes)}`, session.first ? "coarse" : "");
      return;
    }
    this.count(session, () => this.update(slices, rays));
    const shown = slices.filter((panel) => panel.isShown).map((panel) => panel.shownLevel());
    const seen = rays.fidelity();
    const isBeside = shown.length > 0 && seen !== undefined && seen.level > 0;
    const rayText = isBeside ? `, 3-D ${levelText(session.facts.levels[seen.level]!)}` : "";
    if (shown.length === 0 && seen) shown.push(seen.level);
    const level = Math.max(0, ...shown);
    const isWhole = level === 0 && this.missingBytes === 0;
    const text =
      level === 0 ? "full resolution" : `${levelText(session.facts.levels[level]!)} shown`;
    const error = session.facts.maxError > 0 ? ", lossy file" : "";
    const come = isWhole ? "" : `; ${byteText(bytes)} of ${byteText(bytes + this.missingBytes)}`;
    const next = this.opening && `; ${this.opening}`;
    this.say(text + rayText + error + come + next, level === 0 ? "full" : "coarse");
  }

  /** Bytes that are still to come, asked of the index now and then; the line is written again
   *  after that, as no picture need be drawn any more. */
  private count(session: Session, update: () => void): void {
    const sessions = [session, this.overlay()].filter((s) => s !== undefined);
    const boxes = sessions.flatMap((s) => s.cells.missing().map((box) => ({ s, ...box })));
    if (boxes.length === 0) {
      this.missingBytes = 0;
      return;
    }
    this.again ??= setTimeout(() => {
      this.again = undefined;
      update();
    }, EVERY_MS);
    if (this.isCounting || performance.now() - this.countedAt < EVERY_MS) return;
    this.isCounting = true;
    void Promise.all(boxes.map(({ s, level, box }) => s.volume.need(level, box)))
      .then((needs) => {
        if (this.session() !== session) return;
        this.missingBytes = needs.reduce((sum, n) => sum + n.neededBytes - n.presentBytes, 0);
      })
      .catch(() => undefined) // Reading says what is wrong.
      .finally(() => {
        this.isCounting = false;
        this.countedAt = performance.now();
        update();
      });
  }
}

// What lies under the cursor: voxel, place, value, label, o-code. The value is that of the scan, or
// the level it is of is said.
import { type Vec3, AXES } from "../reader/volume.js";
import { CELL_SIDE } from "../decode/cells.js";
import { type Store } from "../store/state.js";
import { levelText, placeText } from "../view/geometry.js";
import { nameOf } from "../view/label_color.js";
import { oCode, rootLevel } from "../view/o_code.js";
import { realText } from "../view/value_text.js";
import { byId, shownText } from "./dom.js";
import { type Session } from "./session.js";

export function valueText(session: Session, voxel: Vec3): string {
  const { facts } = session;
  const known = session.valueAt(voxel);
  if (!known) return "…";
  const level = known.level === 0 ? "" : ` (of ${levelText(facts.levels[known.level]!)})`;
  if (facts.kind === "labels") {
    return `${known.stored} ${shownText(nameOf(facts.labels, known.stored), 80)}${level}`;
  }
  const real = known.stored * facts.slope + facts.intercept;
  const unit = facts.unit === "" ? "" : ` ${shownText(facts.unit, 20)}`;
  return `${realText(facts, real)}${unit}${level}`;
}

export class Readout {
  private readonly line = byId("readout");
  private readonly spoken = byId("spoken");
  private hovered: Vec3 | undefined;
  private speakTimer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly store: Store,
    private readonly session: () => Session | undefined,
    private readonly overlay: () => Session | undefined,
  ) {}

  hover(voxel: Vec3 | undefined): void {
    this.hovered = voxel;
    this.draw();
  }

  /** The voxel under the crosshair is always read at full resolution. */
  want(): void {
    const at = this.store.now.at;
    for (const session of [this.session(), this.overlay()]) {
      if (!session?.hasPreview || session.preview === 0) continue;
      const voxel = session === this.session() ? at : this.session()!.voxelIn(session, at);
      const cell =
        voxel && (AXES.map((a) => Math.floor(voxel[a] / CELL_SIDE)) as unknown as Vec3);
      session.cells.want("cursor", cell ? [{ level: 0, cells: [{ level: 0, at: cell }] }] : []);
    }
  }

  text(voxel: Vec3): string {
    const session = this.session();
    if (!session) return "";
    const parts = [`voxel ${voxel.join(", ")}`, placeText(session.facts, voxel)];
    parts.push(valueText(session, voxel));
    const over = this.overlay();
    const inOver = over && session.voxelIn(over, voxel);
    if (over && inOver) parts.push(valueText(over, inOver));
    const root = rootLevel(session.facts.levels[0]!.size);
    // A volume of one voxel is its root, whose name has no digits.
    if (root > 0) parts.push(`o-code ${oCode(voxel, root)}`);
    return parts.filter((part) => part !== "").join(" · ");
  }

  draw(): void {
    if (!this.session()) return;
    this.line.textContent = this.text(this.hovered ?? this.store.now.at);
    clearTimeout(this.speakTimer);
    // Read out once the crosshair rests.
    this.speakTimer = setTimeout(() => {
      const text = this.text(this.store.now.at);
      if (this.spoken.textContent !== text) this.spoken.textContent = text;
    }, 600);
  }
}

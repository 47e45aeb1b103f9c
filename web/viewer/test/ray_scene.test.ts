import assert from "node:assert/strict";
import test from "node:test";
import { type Vec3, type VolumeFacts, type Voxels } from "../src/reader/volume.js";
import { type Cell, boxSize, cellBox, cellKey } from "../src/decode/cells.js";
import { SlotTable } from "../src/view/atlas.js";
import { RayScene, type Visible, withoutGaps } from "../src/view/ray_scene.js";
import { MadeUpVolume } from "./made_up_volume.js";

const size: Vec3 = [200, 240, 160];
const everything = { lo: [0, 0, 0] as Vec3, hi: size };
const bone: Visible = (_, high) => high >= 500;

class Cells {
  readonly all = new Map<string, Voxels>();
  peek(cell: Cell): Voxels | undefined {
    return this.all.get(cellKey(cell));
  }
  has(cell: Cell): boolean {
    return this.all.has(cellKey(cell));
  }
}

async function scene(
  slots: Vec3,
): Promise<{ scene: RayScene; cells: Cells; volume: MadeUpVolume }> {
  const volume = new MadeUpVolume({ size });
  const cells = new Cells();
  const made = new RayScene(volume.facts, cells, new SlotTable(slots), 2, await volume.ranges());
  return { scene: made, cells, volume };
}

test("coarse levels are wanted first, and only what can be seen", async () => {
  const { scene: s } = await scene([10, 10, 10]);
  const steps = s.plan(0, bone, everything);
  assert.deepEqual(
    steps.map((step) => step.level),
    [2, 1, 0],
  );
  assert.deepEqual(s.grid, [7, 8, 5]);
  assert.equal(s.plan(0, () => false, everything).length, 0);
  const part = s.plan(0, bone, { lo: [0, 0, 0], hi: [32, 240, 160] });
  const all = (steps2: typeof steps): number =>
    steps2.reduce((n, step) => n + step.cells.length, 0);
  assert.ok(all(part) < all(steps));
});

test("pages of infinities alone are wanted where the largest value is seen", async () => {
  const whole: Vec3 = [128, 128, 128];
  const made = new MadeUpVolume({ size: whole }).facts;
  const facts: VolumeFacts = { ...made, type: "float32", range: [-50, 40], slope: 1, intercept: 0 };
  // Of 64 x 64 x 64 voxels, as the index has them: the last block is infinite alone.
  const ranges = {
    grid: [2, 2, 2] as Vec3,
    side: [64, 64, 64] as Vec3,
    min: new Float64Array(8).fill(-50),
    max: new Float64Array(8).fill(30),
  };
  const coarse = 2;
  const samples = boxSize(cellBox(facts.levels[coarse]!, [0, 0, 0]));
  const at = (p: Vec3): boolean => p.every((v, a) => 2 * v >= samples[a as 0]!);
  for (const [value, seen] of [[Infinity, 1], [-Infinity, 0], [NaN, 0]] as const) {
    const voxels = new Float32Array(samples[0] * samples[1] * samples[2]);
    for (let i = 0; i < voxels.length; ++i) {
      const x = i % samples[0];
      const y = Math.floor(i / samples[0]) % samples[1];
      voxels[i] = at([x, y, Math.floor(i / samples[0] / samples[1])]) ? value : 5;
    }
    const peek = (): Voxels => voxels;
    const known = withoutGaps(ranges, facts, coarse, peek);
    assert.deepEqual([...known.max], [30, 30, 30, 30, 30, 30, 30, seen ? 40 : 30]);
    const cells = { peek, has: () => true };
    const s = new RayScene(facts, cells, new SlotTable([10, 10, 10]), coarse, known);
    const steps = s.plan(0, (_, high) => high >= 35, { lo: [0, 0, 0], hi: whole });
    const finest = steps.find((step) => step.level === 0)?.cells ?? [];
    assert.deepEqual(finest.map((cell) => cell.at), seen ? [[1, 1, 1]] : []);
  }
  // Where the lowest value is seen, NaN is.
  const nan = new Float32Array(samples[0] * samples[1] * samples[2]).fill(NaN);
  const floor = { ...ranges, min: new Float64Array(8).fill(-20) };
  assert.deepEqual([...withoutGaps(floor, facts, coarse, () => nan).min], Array(8).fill(-50));
});

test("where the atlas has no room for a level, the next coarser one is the finest", async () => {
  const { scene: s } = await scene([4, 4, 4]);
  s.plan(0, bone, everything);
  assert.equal(s.level, 1);
});

test("the table leads to pages that are here, coarser ones until then", async () => {
  const { scene: s, cells, volume } = await scene([10, 10, 10]);
  const uploads: Vec3[] = [];
  const put = { upload: (slot: Vec3) => uploads.push(slot) };
  const load = async (level: number): Promise<void> => {
    for (const step of s.plan(0, bone, everything)) {
      if (step.level !== level) continue;
      for (const cell of step.cells) {
        const box = cellBox(volume.facts.levels[level]!, cell.at);
        cells.all.set(cellKey(cell), await volume.read(level, box, new AbortController().signal));
      }
    }
    while (s.load(put, 16));
    s.plan(0, bone, everything);
  };
  const levels = (): Set<number> => {
    const { entries } = s.table();
    return new Set([...entries].filter((_, i) => i % 4 === 3));
  };
  assert.deepEqual(levels(), new Set([0]));
  await load(2);
  assert.equal(s.shownLevel(), 2);
  assert.deepEqual([...levels()].sort(), [0, 3]);
  await load(1);
  assert.equal(s.shownLevel(), 1);
  assert.ok(levels().has(2) && !levels().has(1));
  await load(0);
  assert.equal(s.shownLevel(), 0);
  assert.ok(levels().has(1) && !levels().has(2));
  assert.equal(s.plan(0, bone, everything).length, 0);
  const { entries, reach } = s.table();
  for (let i = 0; i < entries.length / 4; ++i) {
    if (entries[4 * i + 3] !== 0) assert.ok(reach[2 * i]! <= reach[2 * i + 1]!);
  }
  assert.equal(new Set(uploads.map((slot) => slot.join())).size <= 1000, true);
});

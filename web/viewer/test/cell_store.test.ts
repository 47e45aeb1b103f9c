import assert from "node:assert/strict";
import test from "node:test";
import { ReadFailure, type Vec3 } from "../src/reader/volume.js";
import { cellBox, cellsOf, wholeBox } from "../src/decode/cells.js";
import { CellStore, cutOut } from "../src/decode/cell_store.js";
import { type MadeUp, MadeUpVolume, valueOf } from "./made_up_volume.js";

interface Made {
  volume: MadeUpVolume;
  store: CellStore;
  errors: Error[];
  settled: () => Promise<void>;
}

function made(options: MadeUp = {}, budget = 1 << 30): Made {
  const volume = new MadeUpVolume(options);
  const errors: Error[] = [];
  const store = new CellStore(
    volume,
    budget,
    () => undefined,
    (error) => errors.push(error),
  );
  const settled = async (): Promise<void> => {
    do await new Promise((resolve) => setTimeout(resolve, 1));
    while (store.isBusy);
  };
  return { volume, store, errors, settled };
}

const size: Vec3 = [96, 112, 80];

test("one step is one read, and its cells hold the voxels of their boxes", async () => {
  const { volume, store, settled } = made();
  const level = volume.facts.levels[0]!;
  const cells = cellsOf(0, wholeBox(level));
  store.want("a", [{ level: 0, cells }]);
  await settled();
  assert.equal(volume.reads.length, 1);
  const cell = { level: 0, at: [1, 1, 0] as Vec3 };
  const box = cellBox(level, cell.at);
  const voxels = store.peek(cell)!;
  assert.equal(voxels.length, 32 * 48 * 64);
  assert.equal(voxels[(3 * 48 + 2) * 32 + 1], valueOf(size, box.lo[0] + 1, box.lo[1] + 2, 3));
});

test("steps come in their order, and nothing is read twice", async () => {
  const { volume, store, settled } = made();
  const of = (level: number): { level: number; cells: ReturnType<typeof cellsOf> } => ({
    level,
    cells: cellsOf(level, wholeBox(volume.facts.levels[level]!)),
  });
  store.want("a", [of(2), of(1)]);
  store.want("b", [of(1)]);
  await settled();
  assert.deepEqual(volume.reads.map((read) => read.level).sort(), [1, 2]);
  store.want("a", [of(1)]);
  await settled();
  assert.equal(volume.reads.length, 2);
});

test("what is no longer wanted is given up, and not kept", async () => {
  const { volume, store, settled, errors } = made({ delayMs: 20 });
  const far = { level: 0, at: [1, 1, 1] as Vec3 };
  const near = { level: 0, at: [0, 0, 0] as Vec3 };
  store.want("a", [{ level: 0, cells: [far] }]);
  store.want("a", [{ level: 0, cells: [near] }]);
  await settled();
  await new Promise((resolve) => setTimeout(resolve, 40));
  assert.equal(store.has(far), false);
  assert.equal(store.has(near), true);
  assert.equal(errors.length, 0);
  assert.equal(volume.reads.length, 2);
});

test("memory stays within its limit: pinned cells and wanted ones stay", async () => {
  const cellBytes = 64 ** 3 * 2;
  const { store, settled } = made({ size: [640, 64, 64] }, 4 * cellBytes);
  const cell = (x: number): { level: number; at: Vec3 } => ({ level: 0, at: [x, 0, 0] });
  store.pin([cell(0)]);
  for (let x = 0; x < 10; ++x) {
    store.want("a", [{ level: 0, cells: [cell(x)] }]);
    await settled();
    assert.ok(store.heldBytes <= 4 * cellBytes, `${store.heldBytes}`);
  }
  assert.ok(store.has(cell(0)) && store.has(cell(9)) && !store.has(cell(3)));
});

test("a failure stops reading until somebody tries again", async () => {
  let isDown = true;
  const { volume, store, settled, errors } = made({
    fail: () => (isDown ? new ReadFailure("the server is gone", "retry") : undefined),
  });
  const cells = [{ level: 1, at: [0, 0, 0] as Vec3 }];
  store.want("a", [{ level: 1, cells }]);
  await settled();
  store.want("b", [{ level: 1, cells }]);
  await settled();
  assert.deepEqual(
    errors.map((e) => e.message),
    ["the server is gone"],
  );
  assert.equal(volume.reads.length, 1);
  assert.equal(store.missing().length, 2);
  isDown = false;
  store.retry();
  await settled();
  assert.equal(store.has(cells[0]!), true);
  assert.equal(store.missing().length, 0);
});

test("a part of an array is cut out row by row", () => {
  const whole = Int16Array.from({ length: 4 * 3 * 2 }, (_, i) => i);
  const part = cutOut(
    whole,
    { lo: [10, 20, 30], hi: [14, 23, 32] },
    { lo: [11, 21, 31], hi: [13, 23, 32] },
  );
  assert.deepEqual([...part], [17, 18, 21, 22]);
});

test("reads that end because the volume is closed elsewhere are no failure", async () => {
  const volume = new MadeUpVolume();
  volume.read = () => Promise.reject(new DOMException("closed", "AbortError"));
  let failures = 0;
  const store = new CellStore(
    volume,
    1 << 30,
    () => undefined,
    () => (failures += 1),
  );
  store.want("a", [{ level: 0, cells: [{ level: 0, at: [0, 0, 0] }] }]);
  await new Promise((resolve) => setTimeout(resolve, 0));
  assert.equal(failures, 0);
  assert.equal(store.failure, undefined);
  assert.equal(store.isBusy, false);
});

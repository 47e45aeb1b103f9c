// An opened file: plans, fetches and decodes boxes of it.
import type {
  Box, BrickRanges, ErrorKind, FileFacts, LabelInfo, Level, Plan, ReadOptions, Statistics,
  Vector3, Volume, VoxelArray,
} from "../api.js";
import type { DecodedBox, Decoders, PoolFile } from "../decode/decoders.js";
import type { EngineFile } from "../decode/engine.js";
import { cancelled, failureOf, OctavoError } from "../errors.js";
import { requireSignal } from "../given.js";
import { platform } from "../platform/browser.js";
import { ShortAnswer } from "../store/fetchers.js";
import type { FileBytes, WaitOptions } from "../store/file_bytes.js";
import { type ByteRange, totalLength } from "../store/ranges.js";
import {
  arrayOf, type Cell, cellsOf, checkBox, checkVector, copyPart, cornersOf, halvesOf, newArray,
  voxelCount,
} from "./cells.js";
import { levelFor, toIndex, toWorld } from "./geometry.js";
import { type NeededBytes, Planner } from "./planner.js";
import { type Identity, isDamage } from "./identity.js";

/** What octavo_describe gives. */
export interface Description extends FileFacts {
  readonly labels: readonly LabelInfo[];
}

export interface VolumeParts {
  readonly description: Description;
  readonly metadataText: string;
  readonly bytes: FileBytes;
  readonly cacheBytes: number;
  readonly pool: Decoders;
  readonly index: EngineFile;
  readonly identity: Identity;
  openAgain(options: ReadOptions): Promise<Volume>;
}

/** The constructor assigns these, as they are described. */
export interface OpenVolume extends FileFacts {}

export class OpenVolume implements Volume {
  readonly labels: ReadonlyMap<number, LabelInfo>;
  readonly name: string;
  readonly byteLength: number;
  readonly metadataText: string;
  readonly metadata: unknown;
  private readonly planner: Planner;
  private readonly file: PoolFile;
  private ended: OctavoError | null = null;
  private voxels = 0;
  private decodeMs = 0;

  constructor(private readonly parts: VolumeParts) {
    const { description, bytes, pool, index } = parts;
    Object.assign(this, description);
    this.labels = new Map(description.labels.map((label) => [label.label, label]));
    this.name = bytes.name;
    this.byteLength = index.opening.size;
    this.metadataText = parts.metadataText;
    this.metadata = jsonOf(parts.metadataText);
    this.planner = new Planner(index, bytes);
    this.file = {
      number: pool.register(),
      opening: { ...index.opening, cacheBytes: pool.cacheBytes },
      supply: (ranges) => bytes.bytesOf(ranges),
    };
  }

  get hostNote(): string {
    return this.parts.bytes.hostNote;
  }

  get statistics(): Statistics {
    const { bytes } = this.parts;
    return {
      requests: bytes.requests, retries: bytes.retries, fetchedBytes: bytes.fetchedBytes,
      cachedBytes: bytes.store.byteLength, pendingRequests: bytes.pending,
      voxels: this.voxels, decodeMs: this.decodeMs,
    };
  }

  async read(box: Box, level: number, options: ReadOptions = {}): Promise<VoxelArray> {
    const ladder = this.checked(box, level);
    return this.named(options.signal, async () => {
      const cells = cellsOf(box, ladder);
      if (cells.length === 1) {
        await this.bring(box, ladder, options);
        return this.decode(cells[0]!, ladder, options);
      }
      const all = newArray(this.type, voxelCount(box), this.name);
      await this.readInto(all, box, box, ladder, options);
      return all;
    });
  }

  async readReal(box: Box, level: number, options: ReadOptions = {}): Promise<Float32Array> {
    const stored = await this.read(box, level, options);
    const real = stored instanceof Float32Array ? stored : new Float32Array(stored.length);
    for (let i = 0; i < stored.length; ++i) real[i] = this.slope * stored[i]! + this.intercept;
    return real;
  }

  async plan(box: Box, level: number, options: ReadOptions = {}): Promise<Plan> {
    this.checked(box, level);
    return this.named(options.signal, async () => {
      const needed = await this.needed(box, level, options, false);
      const { bytes } = this.parts;
      const neededBytes = totalLength(needed.ranges);
      const requests = bytes.plan(needed.ranges);
      return {
        level, isComplete: needed.isComplete, neededBytes,
        presentBytes: neededBytes - totalLength(bytes.missing(needed.ranges)),
        requests: requests.length, requestBytes: totalLength(requests),
        bricks: needed.bricks, uniformBricks: needed.uniformBricks,
      };
    });
  }

  async brickRanges(
    bricks: Box, level: number, options: ReadOptions = {}): Promise<BrickRanges> {
    const ladder = this.levelAt(level);
    checkBox(bricks, ladder.brickGrid, this.name, `the bricks of level ${level}`);
    const count = voxelCount(bricks);
    const scaled = (corner: Vector3) => corner.map((at, axis) =>
      Math.min(at * ladder.brickSide[axis]!, ladder.size[axis]!)) as unknown as Vector3;
    const box = { lo: scaled(bricks.lo), hi: scaled(bricks.hi) };
    return this.named(options.signal, () => this.onceMore(async (wait) => {
      await this.planner.bringPages(box, level, wait);
      return this.parts.index.use((exports, volume, engine) => {
        const place = exports.octavo_allocate(16 * count);
        engine.withBox(cornersOf(bricks), (corners) =>
          exports.octavo_brick_ranges(volume, corners, level, place, place + 8 * count));
        const values = new Float64Array(exports.memory.buffer.slice(place, place + 16 * count));
        exports.octavo_free(place);
        return { box: bricks, min: values.subarray(0, count), max: values.subarray(count) };
      });
    }, options));
  }

  toReal(voxel: number): number {
    return this.slope * voxel + this.intercept;
  }

  toWorld(index: Vector3, level = 0): Vector3 {
    checkVector(index, this.name, "the index");
    return toWorld(index, this.levelAt(level), this.direction);
  }

  toIndex(worldMm: Vector3, level = 0): Vector3 {
    checkVector(worldMm, this.name, "the place");
    return toIndex(worldMm, this.levelAt(level), this.direction);
  }

  levelFor(spacingMm: number): number {
    return levelFor(this.levels, spacingMm);
  }

  labelInfo(label: number): LabelInfo {
    const named = this.labels.get(label);
    if (named) return named;
    const color = this.parts.pool.engine.guard((exports) => exports.octavo_label_color(label));
    return {
      label, name: String(label), color: [color & 255, (color >> 8) & 255, (color >> 16) & 255] };
  }

  oCode(voxel: Vector3, level = 0): string {
    checkVector(voxel, this.name, "the voxel");
    const isInside = voxel.every((at, axis) =>
      Number.isInteger(at) && at >= 0 && at < this.size[axis]!);
    if (!isInside) {
      throw new OctavoError("invalid_argument",
        `${this.name}: no voxel ${voxel.join(",")} in ${this.size.join(" x ")}`);
    }
    const root = Math.ceil(Math.log2(Math.max(...this.size)));
    if (!(Number.isInteger(level) && level >= 0 && level <= root)) {
      throw new OctavoError("invalid_argument",
        `${this.name}: no cubes of level ${String(level)}; the whole is one of level ${root}`);
    }
    const { engine } = this.parts.pool;
    return engine.guard((exports) => engine.withBox([...this.size, ...voxel], (place) =>
      engine.text(exports.octavo_o_code(place, place + 24, level))));
  }

  async thumbnail(options: ReadOptions = {}): Promise<Blob | null> {
    return this.named(options.signal, () => this.onceMore(async (wait) => {
      const { index, bytes } = this.parts;
      const plan = await index.use((exports, volume, engine) =>
        engine.plan(exports.octavo_plan_thumbnail(volume)));
      for (const part of await bytes.bytesOf(plan.ranges, wait)) await index.put(part);
      return index.use((exports, volume) => {
        const count = exports.octavo_thumbnail_bytes(volume);
        if (count === 0) return null;
        const place = exports.octavo_thumbnail(volume);
        return new Blob([exports.memory.buffer.slice(place, place + count)], { type: "image/png" });
      });
    }, options));
  }

  async reopen(options: ReadOptions = {}): Promise<Volume> {
    this.close();
    return this.parts.openAgain(options);
  }

  close(): void {
    this.ended ??= new OctavoError("closed", `${this.name}: closed`);
    this.parts.pool.forget(this.file.number);
    this.parts.bytes.close();
  }

  private levelAt(level: number): Level {
    const found = Number.isInteger(level) ? this.levels[level] : undefined;
    if (found) return found;
    throw new OctavoError("invalid_argument",
      `${this.name}: level ${String(level)}; the file has levels 0 to ${this.levels.length - 1}`);
  }

  private checked(box: Box, level: number): Level {
    const ladder = this.levelAt(level);
    checkBox(box, ladder.size, this.name, `level ${level}`);
    return ladder;
  }

  /** What `work` gives; its failures are those of this package and end what they have to end. */
  private async named<T>(signal: AbortSignal | undefined, work: () => Promise<T>): Promise<T> {
    this.throwIfEnded("replaced", "closed");
    requireSignal(signal);
    if (signal?.aborted) throw cancelled(this.name, signal);
    if (signal) platform.expectListeners(signal);
    try {
      const result = await work();
      this.throwIfEnded("closed");
      return result;
    } catch (cause) {
      const failure = await this.whyFailed(cause);
      if (failure.kind === "replaced") this.ended ??= failure;
      if (failure.kind === "closed" && this.ended) throw this.ended;
      throw failure;
    }
  }

  private throwIfEnded(...kinds: readonly ErrorKind[]): void {
    if (this.ended && kinds.includes(this.ended.kind)) throw this.ended;
  }

  private async whyFailed(cause: unknown): Promise<OctavoError> {
    const failure = failureOf(cause, this.name);
    if (!(failure.cause instanceof ShortAnswer)) return failure;
    // Where the server hides how long the file is, a shorter one has to be looked for.
    return this.parts.identity.prove().then(() => failure, (other: unknown) =>
      failureOf(other, this.name));
  }

  /** Does it once more past all caches where the bytes were damaged and the file is the same. */
  private async onceMore<T>(
    work: (wait: WaitOptions) => Promise<T>, options: ReadOptions): Promise<T> {
    const wait = { signal: options.signal, priority: options.priority };
    try {
      return await work(wait);
    } catch (cause) {
      if (!isDamage(cause)) throw cause;
      await this.parts.identity.prove();
      return work({ ...wait, fresh: true });
    }
  }

  private needed(
    box: Box, level: number, options: ReadOptions, isFetching: boolean): Promise<NeededBytes> {
    return this.onceMore(
      (wait) => this.planner.needed(box, level, wait, isFetching ? wait : null), options);
  }

  /** Asks for all bytes of a box at once; cells wait for their own. */
  private async bring(box: Box, ladder: Level, options: ReadOptions): Promise<ByteRange[]> {
    const needed = await this.needed(box, ladder.level, options, true);
    await this.parts.bytes.ensure(needed.ranges, options);
    return needed.ranges;
  }

  /** Reads a part of `box` into the array of `box`; in halves where its bytes take much room. */
  private async readInto(
    all: VoxelArray, part: Box, box: Box, ladder: Level, options: ReadOptions): Promise<void> {
    const { bytes, cacheBytes } = this.parts;
    const needed = await this.needed(part, ladder.level, options, true);
    const halves = totalLength(needed.ranges) > cacheBytes / 2 ? halvesOf(part, ladder) : null;
    if (halves) {
      for (const half of halves) await this.readInto(all, half, box, ladder, options);
      return;
    }
    const whole = bytes.ensure(needed.ranges, options);
    const cells = cellsOf(part, ladder).map(async (cell) => {
      await this.bring(cell.box, ladder, options);
      copyPart(await this.decode(cell, ladder, options), cell.box, all, box);
    });
    // Whichever fails first; the others are over before anybody hears of it.
    const results = await Promise.allSettled([whole, ...cells]);
    const failed = results.find((result) => result.status === "rejected");
    if (failed) throw failed.reason;
  }

  private async decode(cell: Cell, ladder: Level, options: ReadOptions): Promise<VoxelArray> {
    let decoded: DecodedBox;
    try {
      decoded = await this.decodeOnce(cell, ladder, options);
    } catch (cause) {
      if (!isDamage(cause)) throw cause;
      await this.parts.identity.prove();
      const { ranges } = await this.needed(cell.box, ladder.level, options, true);
      await this.parts.bytes.ensure(ranges, { ...options, fresh: true });
      decoded = await this.decodeOnce(cell, ladder, options);
    }
    this.voxels += voxelCount(cell.box);
    this.decodeMs += decoded.ms;
    return arrayOf(this.type, decoded.voxels);
  }

  private decodeOnce(cell: Cell, ladder: Level, options: ReadOptions): Promise<DecodedBox> {
    return this.parts.pool.read(this.file, {
      level: ladder.level, box: cornersOf(cell.box), type: this.type, key: cell.key,
      priority: options.priority ?? 0, signal: options.signal,
    });
  }
}

function jsonOf(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return null;
  }
}

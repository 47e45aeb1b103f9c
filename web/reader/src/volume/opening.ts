// From a source to a volume: the header, then the tail of the file.
import type { Open, OpenOptions, Pool, Source, Volume } from "../api.js";
import type { Decoders } from "../decode/decoders.js";
import { createVolume, Engine, EngineFile } from "../decode/engine.js";
import { WorkerPool } from "../decode/pool.js";
import { failureOf, OctavoError } from "../errors.js";
import { countOr, requireSignal } from "../given.js";
import { platform } from "../platform/browser.js";
import { FileBytes, type PlacedBytes, type WaitOptions } from "../store/file_bytes.js";
import { fetcherOf } from "../store/fetchers.js";
import type { ByteRange } from "../store/ranges.js";
import { Identity, isDamage } from "./identity.js";
import { type Description, OpenVolume } from "./volume.js";

/** What is asked for first: header, first model, and all of a small file. */
const firstBytes = 64 * 1024;
/** What is asked for in front of the tail: coarse levels, as a rule. */
const extraBytes = 96 * 1024;
const headerBytes = 512;
const trailerBytes = 96;

let shared: Promise<WorkerPool> | null = null;

/** The pool of those who name none. */
function sharedPool(): Promise<WorkerPool> {
  shared ??= WorkerPool.create();
  // The next one tries again.
  shared.catch(() => {
    shared = null;
  });
  return shared;
}

function isDecoders(pool: Pool): pool is Decoders {
  return (pool as Partial<Decoders>).engine !== undefined;
}

export const open: Open = async (source, options) => {
  try {
    return await opened(source, options ?? {});
  } catch (cause) {
    throw failureOf(cause, options?.name ?? (typeof source === "string" ? source : "file"));
  }
};

async function opened(source: Source, options: OpenOptions): Promise<Volume> {
  requireSignal(options.signal);
  if (options.signal) platform.expectListeners(options.signal);
  const pool = options.pool ?? await sharedPool();
  if (!isDecoders(pool)) {
    throw new OctavoError("invalid_argument", "the pool is none of createPool");
  }
  const cacheBytes = countOr(128 * 1024 * 1024, options.cacheBytes, "cacheBytes");
  const bytes = new FileBytes(
    fetcherOf(source, {
      wholeFileBytes: countOr(50e6, options.wholeFileBytes, "wholeFileBytes"),
      credentials: options.credentials ?? "omit",
      ...(options.name === undefined ? {} : { name: options.name }),
    }),
    {
      cacheBytes,
      parallelRequests: Math.max(1, countOr(6, options.parallelRequests, "parallelRequests")),
      joinGapBytes: countOr(32 * 1024, options.joinGapBytes, "joinGapBytes"),
      onSlow: options.onSlow,
    });
  const opening = new Opening(bytes, pool, source, options, cacheBytes);
  try {
    return await opening.volume({ signal: options.signal });
  } catch (cause) {
    // Header and tail of two files, when one takes the place of another between two requests; or
    // a page that was sent, and kept, in place of the file.
    const isElse = cause instanceof OctavoError && cause.kind === "not_octavo";
    if (!(isDamage(cause) || isElse) || bytes.fetcher.size !== undefined) throw cause;
    bytes.store.clear();
    bytes.size = undefined;
    return opening.volume({ signal: options.signal, fresh: true });
  }
}

class Opening {
  constructor(
    private readonly bytes: FileBytes, private readonly pool: Decoders,
    private readonly source: Source, private readonly options: OpenOptions,
    private readonly cacheBytes: number) {}

  async volume(wait: WaitOptions): Promise<Volume> {
    const { bytes, pool } = this;
    await bytes.ensure([{ offset: 0, length: firstBytes }], wait);
    const engine = await Engine.create(pool.module, bytes.name);
    const size = this.sizeOf(engine);
    const parts = await this.bringTail(engine, size, wait);
    const index = new EngineFile(pool.module, { name: bytes.name, size, cacheBytes: 0, parts });
    const [json, metadataText] = await index.use((exports, volume, own) => [
      own.text(exports.octavo_describe(volume)), own.text(exports.octavo_metadata(volume))]);
    const ends = [
      { offset: 0, length: headerBytes }, { offset: size - trailerBytes, length: trailerBytes }];
    const identity = new Identity(bytes, await bytes.bytesOf(ends));
    bytes.isOpen = true;
    return new OpenVolume({
      description: JSON.parse(json) as Description, metadataText, bytes, pool, index, identity,
      cacheBytes: this.cacheBytes,
      openAgain: ({ signal }) =>
        open(this.source, { ...this.options, ...(signal ? { signal } : {}) }),
    });
  }

  /** Servers may hide the length of a file from pages of other sites; its header has it. */
  private sizeOf(engine: Engine): number {
    const { bytes } = this;
    if (bytes.size === undefined) {
      const start = bytes.read({ offset: 0, length: headerBytes });
      const length = start === null ? 0 : engine.guard((exports) =>
        engine.with(start, (place) => exports.octavo_length_of(place, start.length)));
      bytes.size = Math.max(length, firstBytes);
    }
    return bytes.size;
  }

  /** The bytes that open the file. */
  private async bringTail(engine: Engine, size: number, wait: WaitOptions): Promise<PlacedBytes[]> {
    const { bytes } = this;
    const parts: PlacedBytes[] = [];
    const volume = engine.guard(() => createVolume(engine, size, bytes.name));
    for (;;) {
      const plan = engine.guard((exports) => engine.plan(exports.octavo_plan_opening(volume)));
      if (plan.ranges.length === 0 && plan.isComplete) return parts;
      await bytes.ensure(plan.ranges.map(withExtra), wait);
      for (const part of await bytes.bytesOf(plan.ranges, { signal: wait.signal })) {
        parts.push(part);
        engine.guard((exports) => engine.with(part.bytes, (place) =>
          exports.octavo_put(volume, part.offset, place, part.bytes.length)));
      }
    }
  }
}

function withExtra({ offset, length }: ByteRange): ByteRange {
  const start = Math.max(0, offset - extraBytes);
  return { offset: start, length: offset + length - start };
}

// One instance of octavo.wasm, and one file in it.
//
// What the decoder throws comes here as an OctavoError. No destructor has run then: the instance
// is dropped, and a new one gets the bytes that open the file.
import type { ErrorKind } from "../api.js";
import { OctavoError } from "../errors.js";
import type { PlacedBytes } from "../store/file_bytes.js";
import type { ByteRange } from "../store/ranges.js";

/** reader_api.cpp has their meanings. Pointers are numbers. */
export interface EngineExports {
  readonly memory: WebAssembly.Memory;
  _initialize(): void;
  octavo_allocate(bytes: number): number;
  octavo_free(memory: number): void;
  octavo_length_of(bytes: number, count: number): number;
  octavo_create(size: number, name: number, nameBytes: number): number;
  octavo_put(volume: number, offset: number, bytes: number, count: number): void;
  octavo_forget(volume: number, mostBytes: number): void;
  octavo_plan_opening(volume: number): number;
  octavo_open(volume: number, cacheBytes: number): void;
  octavo_describe(volume: number): number;
  octavo_metadata(volume: number): number;
  octavo_plan_pages(volume: number, box: number, level: number): number;
  octavo_plan(volume: number, box: number, level: number): number;
  octavo_read(volume: number, box: number, level: number, out: number): void;
  octavo_brick_ranges(
    volume: number, bricks: number, level: number, min: number, max: number): void;
  octavo_plan_thumbnail(volume: number): number;
  octavo_thumbnail_bytes(volume: number): number;
  octavo_thumbnail(volume: number): number;
  octavo_o_code(size: number, voxel: number, level: number): number;
  octavo_label_color(label: number): number;
}

/** In the order of ErrorKind in core/error.h. */
const kinds: readonly ErrorKind[] = [
  "invalid_argument", "not_octavo", "unsupported_version", "corrupt", "truncated",
  "limit_exceeded", "internal", "io", "out_of_memory", "cancelled", "internal"];
const noMemory = -1;

/** x, y, z of the lower corner, then of the upper one. */
export type Corners = readonly number[];

export interface EnginePlan {
  readonly neededBytes: number;
  readonly isComplete: boolean;
  readonly ranges: ByteRange[];
  /** What stands behind the ranges. */
  readonly rest: number[];
}

export class Engine {
  private constructor(readonly exports: EngineExports, readonly name: string) {}

  static async create(module: WebAssembly.Module, name: string): Promise<Engine> {
    let memory: WebAssembly.Memory | undefined;
    const bytes = () => new Uint8Array(memory!.buffer);
    const imports = {
      octavo: {
        thrown: (kind: number, text: number, length: number) => {
          const words = new TextDecoder().decode(bytes().slice(text, text + length));
          throw kind === noMemory
            ? new OctavoError("out_of_memory", `${name}: no memory left`)
            : new OctavoError(kinds[kind] ?? "internal", named(words, name));
        },
      },
      wasi_snapshot_preview1: systemCalls(() => new DataView(memory!.buffer)),
    };
    const instance = await WebAssembly.instantiate(module, imports);
    const exports = instance.exports as unknown as EngineExports;
    memory = exports.memory;
    exports._initialize();
    return new Engine(exports, name);
  }

  /** What a call gives; whatever it throws is an OctavoError. */
  guard<T>(call: (exports: EngineExports) => T): T {
    try {
      return call(this.exports);
    } catch (cause) {
      if (cause instanceof OctavoError) throw cause;
      const text = cause instanceof Error ? cause.message : String(cause);
      throw new OctavoError("internal", `${this.name}: the decoder stopped: ${text}`, { cause });
    }
  }

  /** Calls `use` with a place in memory that holds these bytes. */
  with<T>(bytes: Uint8Array, use: (place: number) => T): T {
    const place = this.exports.octavo_allocate(bytes.length);
    new Uint8Array(this.exports.memory.buffer).set(bytes, place);
    const result = use(place);
    this.exports.octavo_free(place);
    return result;
  }

  withBox<T>(corners: Corners, use: (place: number) => T): T {
    return this.with(new Uint8Array(new Float64Array(corners).buffer), use);
  }

  text(place: number): string {
    const bytes = new Uint8Array(this.exports.memory.buffer);
    return new TextDecoder().decode(bytes.slice(place, bytes.indexOf(0, place)));
  }

  plan(place: number, restCount = 0): EnginePlan {
    const numbers = new Float64Array(this.exports.memory.buffer, place);
    const count = numbers[2]!;
    const ranges = Array.from({ length: count }, (_, i) => (
      { offset: numbers[3 + 2 * i]!, length: numbers[4 + 2 * i]! }));
    const end = 3 + 2 * count;
    return {
      neededBytes: numbers[0]!, isComplete: numbers[1] === 1, ranges,
      rest: [...numbers.subarray(end, end + restCount)],
    };
  }
}

/** A sentence about a file begins with its name, whoever wrote it. */
function named(words: string, name: string): string {
  return words.startsWith(`${name}: `) ? words : `${name}: ${words}`;
}

/** What the C library asks of a system: there are no variables and no files. */
function systemCalls(view: () => DataView): WebAssembly.ModuleImports {
  const notThere = 8;
  return {
    environ_get: () => 0,
    environ_sizes_get: (count: number, size: number) => {
      view().setUint32(count, 0, true);
      view().setUint32(size, 0, true);
      return 0;
    },
    fd_close: () => notThere,
    fd_seek: () => notThere,
    fd_write: () => notThere,
    fd_fdstat_get: () => notThere,
    proc_exit: () => {
      throw new Error("it ended itself");
    },
  };
}

/** What it takes to open a file once more. */
export interface OpeningBytes {
  readonly name: string;
  readonly size: number;
  readonly cacheBytes: number;
  readonly parts: readonly PlacedBytes[];
}

/** A file in an instance of its own; in a new one after each failure. */
export class EngineFile {
  private engine: Promise<{ engine: Engine; volume: number }> | null = null;

  constructor(readonly module: WebAssembly.Module, readonly opening: OpeningBytes) {}

  /** What `call` gives, which runs without a pause. A failure ends the instance. */
  async use<T>(
    call: (exports: EngineExports, volume: number, engine: Engine) => T): Promise<T> {
    this.engine ??= this.open();
    const own = this.engine;
    try {
      const { engine, volume } = await own;
      return engine.guard((exports) => call(exports, volume, engine));
    } catch (cause) {
      if (this.engine === own) this.engine = null;
      throw cause;
    }
  }

  put(part: PlacedBytes): Promise<void> {
    return this.use((exports, volume, engine) => engine.with(part.bytes, (place) =>
      exports.octavo_put(volume, part.offset, place, part.bytes.length)));
  }

  private async open(): Promise<{ engine: Engine; volume: number }> {
    const { name, size, cacheBytes, parts } = this.opening;
    const engine = await Engine.create(this.module, name);
    return engine.guard((exports) => {
      const volume = createVolume(engine, size, name);
      for (const { offset, bytes } of parts) {
        engine.with(bytes, (place) => exports.octavo_put(volume, offset, place, bytes.length));
      }
      exports.octavo_open(volume, cacheBytes);
      exports.octavo_forget(volume, 0);
      return { engine, volume };
    });
  }
}

export function createVolume(engine: Engine, size: number, name: string): number {
  const text = new TextEncoder().encode(name);
  return engine.with(text, (place) => engine.exports.octavo_create(size, place, text.length));
}

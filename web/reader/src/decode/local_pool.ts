// Decodes on this thread, for places that have no workers: a Service Worker, a worker of one's own.
import type { PoolOptions } from "../api.js";
import { cancelled, OctavoError } from "../errors.js";
import type { DecodedBox, Decoders, JobOptions, PoolFile } from "./decoders.js";
import { Engine, EngineFile } from "./engine.js";
import { compile } from "./module.js";
import { voxelsOf } from "./reading.js";

export class LocalPool implements Decoders {
  readonly workers = 0;
  private readonly files = new Map<number, EngineFile>();
  private last: Promise<unknown> = Promise.resolve();
  private nextNumber = 1;
  private isClosed = false;

  private constructor(
    readonly module: WebAssembly.Module, readonly engine: Engine, readonly cacheBytes: number) {}

  static async create(options: PoolOptions = {}): Promise<LocalPool> {
    const module = await compile(options.wasm);
    return new LocalPool(
      module, await Engine.create(module, "octavo"), options.cacheBytes ?? 32 * 1024 * 1024);
  }

  register(): number {
    return this.nextNumber++;
  }

  forget(file: number): void {
    this.files.delete(file);
  }

  read(file: PoolFile, options: JobOptions): Promise<DecodedBox> {
    // One after the other: an instance decodes one box at a time.
    const decoded = this.last.then(() => this.readNow(file, options));
    this.last = decoded.catch(() => undefined);
    return decoded;
  }

  close(): void {
    this.isClosed = true;
    this.files.clear();
  }

  private async readNow(file: PoolFile, options: JobOptions): Promise<DecodedBox> {
    const { name } = file.opening;
    if (this.isClosed) throw new OctavoError("closed", `${name}: the pool is closed`);
    if (options.signal?.aborted) throw cancelled(name, options.signal);
    let own = this.files.get(file.number);
    if (!own) {
      own = new EngineFile(this.module, file.opening);
      this.files.set(file.number, own);
    }
    const started = performance.now();
    const voxels = await voxelsOf(own, options, (ranges) => file.supply(ranges));
    if (voxels === null) throw cancelled(name, options.signal);
    return { voxels, ms: performance.now() - started };
  }
}

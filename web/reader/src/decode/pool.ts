// The workers of a page: who decodes what, and when.
//
// A brick always goes to the same worker, which may still have it decoded; a worker that has
// nothing to do takes from one that has much. What is wanted most goes first.
import type { ErrorKind, PoolOptions } from "../api.js";
import { cancelled, failureOf, OctavoError } from "../errors.js";
import type { PlacedBytes } from "../store/file_bytes.js";
import type { ByteRange } from "../store/ranges.js";
import type { DecodedBox, Decoders, JobOptions, PoolFile } from "./decoders.js";
import { Engine } from "./engine.js";
import type { FromWorker, ToWorker } from "./messages.js";
import { compile } from "./module.js";
import { platform } from "../platform/browser.js";
import type { WorkerPort } from "../platform/platform.js";

interface Job extends JobOptions {
  readonly number: number;
  readonly file: PoolFile;
  resolve(decoded: DecodedBox): void;
  reject(error: OctavoError): void;
}

/** A queue longer than this gives jobs away. */
const longQueue = 1;

class Slot {
  port: WorkerPort | null = null;
  readonly opened = new Set<number>();
  queue: Job[] = [];
  current: Job | null = null;
}

export class WorkerPool implements Decoders {
  private readonly slots: Slot[];
  private nextNumber = 1;
  private isClosed = false;

  private constructor(
    readonly module: WebAssembly.Module, readonly engine: Engine,
    private readonly worker: string | URL | undefined, workers: number,
    readonly cacheBytes: number) {
    this.slots = Array.from({ length: workers }, () => new Slot());
  }

  /** workers  1 or more */
  static async create(options: PoolOptions = {}): Promise<WorkerPool> {
    const module = await compile(options.wasm);
    const pool = new WorkerPool(
      module, await Engine.create(module, "octavo"), options.worker,
      options.workers ?? usualWorkers(), options.cacheBytes ?? 32 * 1024 * 1024);
    pool.slots.forEach((slot, i) => pool.start(slot, i === 0));
    return pool;
  }

  get workers(): number {
    return this.slots.length;
  }

  register(): number {
    return this.nextNumber++;
  }

  forget(file: number): void {
    for (const slot of this.slots) {
      const [own, others] = [slot.queue.filter((job) => job.file.number === file),
        slot.queue.filter((job) => job.file.number !== file)];
      slot.queue = others;
      for (const job of own) job.reject(new OctavoError("closed", "closed"));
      if (slot.opened.delete(file)) this.post(slot, { kind: "close", file });
    }
  }

  read(file: PoolFile, options: JobOptions): Promise<DecodedBox> {
    return new Promise((resolve, reject) => {
      const { signal } = options;
      const { name } = file.opening;
      if (this.isClosed) return reject(new OctavoError("closed", `${name}: the pool is closed`));
      if (signal?.aborted) return reject(cancelled(name, signal));
      const slot = this.slots[options.key % this.slots.length]!;
      const stop = () => {
        for (const one of this.slots) one.queue = one.queue.filter((other) => other !== job);
        reject(cancelled(name, signal));
      };
      const done = () => signal?.removeEventListener("abort", stop);
      const job: Job = {
        ...options, number: this.nextNumber++, file,
        resolve: (decoded) => { done(); resolve(decoded); },
        reject: (error) => { done(); reject(error); },
      };
      signal?.addEventListener("abort", stop, { once: true });
      slot.queue.push(job);
      for (const one of [slot, ...this.slots]) this.next(one);
    });
  }

  close(): void {
    this.isClosed = true;
    for (const slot of this.slots) {
      slot.port?.end();
      for (const job of [...slot.queue, ...(slot.current ? [slot.current] : [])]) {
        job.reject(new OctavoError("closed", `${job.file.opening.name}: the pool is closed`));
      }
      slot.queue = [];
      slot.current = null;
    }
  }

  private start(slot: Slot, isWarming: boolean): void {
    const port = platform.startWorker(this.worker);
    slot.port = port;
    slot.opened.clear();
    port.listen((message) => this.hear(slot, message as FromWorker));
    port.onEnd((kind, reason) => {
      port.end();
      if (slot.port === port) slot.port = null;
      this.finish(slot, (job) => job.reject(new OctavoError(
        kind, `${job.file.opening.name}: the decoder ended: ${reason}`)));
    });
    port.post({ kind: "start", module: this.module, isWarming } satisfies ToWorker);
  }

  private post(slot: Slot, message: ToWorker, transfer: ArrayBuffer[] = []): void {
    slot.port?.post(message, transfer);
  }

  /** The job that a slot without one does now: the most wanted of its own, or of a long queue. */
  private take(slot: Slot): Job | undefined {
    const longest = this.slots.reduce((a, b) => (a.queue.length >= b.queue.length ? a : b));
    const from = slot.queue.length === 0 && longest.queue.length > longQueue ? longest : slot;
    let best = 0;
    from.queue.forEach((job, i) => {
      if (job.priority > from.queue[best]!.priority) best = i;
    });
    return from.queue.splice(best, 1)[0];
  }

  private next(slot: Slot): void {
    if (slot.current) return;
    const job = this.take(slot);
    if (!job) return;
    slot.current = job;
    try {
      if (!slot.port) this.start(slot, false);
    } catch (cause) {
      // Later: each of a long queue would be one call deeper.
      queueMicrotask(() => this.finish(
        slot, () => job.reject(failureOf(cause, job.file.opening.name))));
      return;
    }
    slot.port?.hold(true);
    if (!slot.opened.has(job.file.number)) {
      slot.opened.add(job.file.number);
      this.post(slot, { kind: "open", file: job.file.number, opening: job.file.opening });
    }
    const { number, file, level, box, type } = job;
    this.post(slot, { kind: "read", job: number, file: file.number, level, box, type });
  }

  private finish(slot: Slot, settle: (job: Job) => void): void {
    const job = slot.current;
    slot.current = null;
    slot.port?.hold(false);
    if (job) settle(job);
    this.next(slot);
  }

  private hear(slot: Slot, said: FromWorker): void {
    const job = slot.current;
    if (!job || job.number !== said.job) return;
    switch (said.kind) {
      case "needs":
        void this.supply(slot, job, said.ranges);
        break;
      case "voxels":
        this.finish(slot, () => job.resolve({ voxels: said.voxels, ms: said.ms }));
        break;
      case "failed":
        this.finish(slot, () => job.reject(new OctavoError(said.error, said.message)));
        break;
    }
  }

  private async supply(slot: Slot, job: Job, ranges: readonly ByteRange[]): Promise<void> {
    let failure: { readonly kind: ErrorKind; readonly message: string } | null = null;
    let parts: PlacedBytes[] = [];
    try {
      if (job.signal?.aborted) throw cancelled(job.file.opening.name, job.signal);
      parts = await job.file.supply(ranges);
    } catch (cause) {
      failure = failureOf(cause, job.file.opening.name);
    }
    if (failure) {
      // The worker ends the job; its answer comes when the job is nobody's any more.
      this.post(slot, { kind: "bytes", job: job.number, parts: null });
      const { kind, message } = failure;
      this.finish(slot, () => job.reject(new OctavoError(kind, message)));
      return;
    }
    this.post(slot, { kind: "bytes", job: job.number, parts },
      parts.map((part) => part.bytes.buffer as ArrayBuffer));
  }
}

function usualWorkers(): number {
  return Math.min(8, Math.max(1, platform.coreCount() - 1));
}

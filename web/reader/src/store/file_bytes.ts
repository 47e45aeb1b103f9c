// The bytes of one file as they come: what is here, what is under way, what waits for its turn.
//
// Ranges are joined into few requests, of which some run at a time. Who waits for bytes that
// somebody else has asked for waits for that request; one that nobody waits for any more is ended.
import { cancelled, failureOf, OctavoError, orCancelled } from "../errors.js";
import { chained, type FetchedBytes, type Fetcher, ShortAnswer, Unsettled } from "./fetchers.js";
import type { SlowServer } from "../api.js";
import { type ByteRange, endOf, joined, RangeStore } from "./ranges.js";
import { SlowWatch, type WatchedRequest } from "./slow_watch.js";

export interface BytesSettings {
  readonly cacheBytes: number;
  readonly parallelRequests: number;
  readonly joinGapBytes: number;
  readonly onSlow?: ((slow: SlowServer | null) => void) | undefined;
}

/** Bytes of a file and where they stand. */
export interface PlacedBytes {
  readonly offset: number;
  readonly bytes: Uint8Array<ArrayBuffer>;
}

export interface WaitOptions {
  readonly signal?: AbortSignal | undefined;
  readonly priority?: number | undefined;
  /** Past all caches on the way, whether the bytes are here or not. */
  readonly fresh?: boolean;
}

/** Where so many requests are not enough, larger holes are fetched along, up to this. */
const mostRequests = 12;
const mostGapBytes = 256 * 1024;
/** A longer request is cut, so that its parts may come at a time. */
const mostRequestBytes = 16 * 1024 * 1024;
const tries = 4;

interface FileRequest extends WatchedRequest {
  readonly range: ByteRange;
  readonly isFresh: boolean;
  readonly controller: AbortController;
  readonly promise: Promise<void>;
  /** The try under way. */
  attempt: AbortController;
  startedAt: number;
  arrivedBytes: number;
  wantedBytes: number;
  priority: number;
  waiters: number;
  start(): void;
}

const meets = (a: ByteRange, b: ByteRange): boolean =>
  a.offset < endOf(b) && b.offset < endOf(a);

export class FileBytes {
  readonly store: RangeStore;
  requests = 0;
  retries = 0;
  fetchedBytes = 0;
  /** Not known before the first bytes came. */
  size: number | undefined;
  hostNote = "";
  /** Header and trailer have been read: where there are fewer bytes now, the file is another. */
  isOpen = false;
  private waiting: FileRequest[] = [];
  private running = new Set<FileRequest>();
  private isClosed = false;
  /** Of servers alone, and only where somebody listens. */
  private readonly watch: SlowWatch | undefined;

  constructor(readonly fetcher: Fetcher, private readonly settings: BytesSettings) {
    this.store = new RangeStore(settings.cacheBytes);
    this.size = fetcher.size;
    const { onSlow } = settings;
    if (onSlow && fetcher.size === undefined) this.watch = new SlowWatch(this.running, onSlow);
  }

  get name(): string {
    return this.fetcher.name;
  }

  get pending(): number {
    return this.running.size + this.waiting.length;
  }

  /** The requests that `ranges` would take now. */
  plan(ranges: readonly ByteRange[]): ByteRange[] {
    let gap = this.settings.joinGapBytes;
    const missing = this.store.missing(ranges);
    let requests = joined(missing, gap);
    while (requests.length > mostRequests && gap > 0 && gap < mostGapBytes) {
      gap *= 2;
      requests = joined(missing, gap);
    }
    return requests.flatMap((range) => cut(range));
  }

  /** Resolves when every byte of `ranges` is here. */
  async ensure(ranges: readonly ByteRange[], options: WaitOptions = {}): Promise<void> {
    if (options.fresh) this.store.drop(ranges);
    // Bytes may be dropped again while others are on their way, when there is little room.
    for (let round = 0; round < 3; ++round) {
      this.throwIfEnded(options.signal);
      const missing = this.missing(ranges);
      if (missing.length === 0) return;
      await this.bring(missing, options);
    }
    if (this.missing(ranges).length > 0) {
      throw this.noRoom();
    }
  }

  /** The parts of ranges that are not here, as far as the file goes. */
  missing(ranges: readonly ByteRange[]): ByteRange[] {
    const size = this.size ?? Infinity;
    return this.store.missing(ranges.map(({ offset, length }) => (
      { offset, length: Math.min(length, size - offset) })));
  }

  /** Copies of the bytes of ranges, fetched where they are not here. */
  async bytesOf(ranges: readonly ByteRange[], options: WaitOptions = {}): Promise<PlacedBytes[]> {
    for (let round = 0; round < 3; ++round) {
      await this.ensure(ranges, round === 0 ? options : { ...options, fresh: false });
      const parts = ranges.map((range) => ({ offset: range.offset, bytes: this.read(range) }));
      if (parts.every((part): part is PlacedBytes => part.bytes !== null)) return parts;
    }
    throw this.noRoom();
  }

  /** A copy of bytes that are here; null where some are missing. */
  read(range: ByteRange): Uint8Array<ArrayBuffer> | null {
    return this.store.read(range);
  }

  close(): void {
    this.isClosed = true;
    for (const request of [...this.waiting, ...this.running]) request.controller.abort();
    // Those that have not begun end as well.
    for (const request of this.waiting.splice(0)) request.start();
    this.store.clear();
  }

  private noRoom(): OctavoError {
    return new OctavoError(
      "out_of_memory", `${this.name}: too little room to keep the bytes that are needed`);
  }

  private throwIfEnded(signal?: AbortSignal): void {
    if (this.isClosed) throw new OctavoError("closed", `${this.name}: closed`);
    if (signal?.aborted) throw cancelled(this.name, signal);
  }

  private async bring(missing: readonly ByteRange[], options: WaitOptions): Promise<void> {
    const underWay = [...this.waiting, ...this.running].filter(
      (request) => !request.controller.signal.aborted && (!options.fresh || request.isFresh));
    const shared = underWay.filter(
      (request) => missing.some((range) => meets(range, request.range)));
    const rest = missing.flatMap((range) => without(range, shared.map((one) => one.range)));
    const own = this.plan(rest).map((range) => this.request(range, options));
    const all = [...shared, ...own];
    for (const request of all) {
      request.waiters += 1;
      request.priority = Math.max(request.priority, options.priority ?? 0);
    }
    this.startSome();
    try {
      await orCancelled(
        Promise.all(all.map((request) => request.promise)), this.name, options.signal);
    } finally {
      for (const request of all) {
        request.waiters -= 1;
        if (request.waiters === 0) this.end(request);
      }
    }
  }

  private request(range: ByteRange, options: WaitOptions): FileRequest {
    let start = (): void => undefined;
    const controller = new AbortController();
    const promise = new Promise<void>((resolve) => {
      start = resolve;
    }).then(() => this.run(request));
    // Whoever waits hears of it; one that nobody waits for fails unheard.
    promise.catch(() => undefined);
    const request: FileRequest = {
      range, isFresh: options.fresh ?? false, controller, promise, waiters: 0,
      priority: options.priority ?? 0, start,
      attempt: controller, startedAt: 0, arrivedBytes: 0, wantedBytes: range.length,
      askAgain: () => request.attempt.abort(),
    };
    this.waiting.push(request);
    return request;
  }

  private startSome(): void {
    this.waiting.sort((a, b) => b.priority - a.priority);
    while (this.running.size < this.settings.parallelRequests) {
      const next = this.waiting.shift();
      if (!next) return;
      this.running.add(next);
      next.startedAt = performance.now();
      next.start();
      this.watch?.changed();
    }
  }

  private end(request: FileRequest): void {
    request.controller.abort();
    this.waiting = this.waiting.filter((one) => one !== request);
  }

  private async run(request: FileRequest): Promise<void> {
    try {
      await this.fetchWithRetries(request);
    } finally {
      this.running.delete(request);
      this.startSome();
      this.watch?.changed();
    }
  }

  private async fetchWithRetries(request: FileRequest): Promise<void> {
    const { signal } = request.controller;
    for (let attempt = 1; ; ++attempt) {
      if (signal.aborted) throw this.ending();
      request.attempt = new AbortController();
      const either = chained(signal, request.attempt);
      request.arrivedBytes = 0;
      try {
        this.requests += 1;
        const { offset, length } = request.range;
        this.take(request.range, await this.fetcher.fetchBytes(
          offset, length, either, request.isFresh, (arrived, wanted) => {
            this.watch?.arrived(arrived - request.arrivedBytes);
            request.arrivedBytes = arrived;
            request.wantedBytes = wanted;
          }));
        return;
      } catch (cause) {
        if (signal.aborted) throw this.ending();
        if (either.aborted) {
          // Somebody asked for another try.
          this.retries += 1;
          attempt = 0;
          continue;
        }
        if (!(cause instanceof Unsettled)) throw this.failureAt(request.range, cause);
        if (attempt === tries) {
          throw new OctavoError(
            "io", `${this.name}: ${cause.message}; tried ${tries} times`, { cause });
        }
        this.retries += 1;
        await pause(Math.max(cause.waitMs, 250 * 3 ** (attempt - 1)), either);
      }
    }
  }

  /** Why a request is ended. */
  private ending(): OctavoError {
    return this.isClosed ? new OctavoError("closed", `${this.name}: closed`) : cancelled(this.name);
  }

  private failureAt(range: ByteRange, cause: unknown): OctavoError {
    const failure = failureOf(cause, this.name);
    const isShorter = failure.kind === "truncated" && this.isOpen &&
      range.offset < (this.size ?? 0);
    return isShorter ? this.replaced("a shorter one") : failure;
  }

  private replaced(what: string): OctavoError {
    return new OctavoError("replaced",
      `${this.name}: another file stands there now, ${what}; open it again`);
  }

  private take(range: ByteRange, fetched: FetchedBytes): void {
    const { bytes, total, isWhole } = fetched;
    if (total !== undefined && this.size !== undefined && total !== this.size) {
      if (this.isOpen) throw this.replaced(`of ${total} bytes instead of ${this.size}`);
      throw new OctavoError("truncated",
        `${this.name}: has ${total} bytes instead of ${this.size}`);
    }
    if (isWhole) {
      this.hostNote =
        `The server of ${this.name} ignores ranges, so all of the file was fetched; ` +
        "one that answers them, such as nginx or caddy, sends only what is looked at.";
      this.store.keepAll();
      this.store.put(0, bytes);
    } else {
      const end = range.offset + bytes.length;
      if (bytes.length < range.length) {
        const size = total ?? this.size;
        if (size === undefined) this.size = end;
        else if (end < size) throw new ShortAnswer("the connection ended early");
      }
      this.store.put(range.offset, bytes);
    }
    if (total !== undefined) this.size = total;
    this.fetchedBytes += bytes.length;
  }
}

/** Parts of a range of at most mostRequestBytes each. */
function cut(range: ByteRange): ByteRange[] {
  const count = Math.ceil(range.length / mostRequestBytes);
  const step = Math.ceil(range.length / Math.max(1, count));
  return Array.from({ length: count }, (_, i) => ({
    offset: range.offset + i * step,
    length: Math.min(step, range.length - i * step),
  }));
}

/** What is left of a range without others. */
function without(range: ByteRange, others: readonly ByteRange[]): ByteRange[] {
  let left = [range];
  for (const other of others) {
    left = left.flatMap((part) => !meets(part, other) ? [part] : [
      { offset: part.offset, length: other.offset - part.offset },
      { offset: endOf(other), length: endOf(part) - endOf(other) },
    ].filter((rest) => rest.length > 0));
  }
  return left;
}

function pause(ms: number, signal: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, ms);
    signal.addEventListener("abort", () => {
      clearTimeout(timer);
      resolve();
    }, { once: true });
  });
}

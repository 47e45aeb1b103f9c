// Where the bytes of a source come from: a URL, a File, memory.
//
// Of a URL only plain ranges are asked for, `bytes=a-b`: anything else makes a browser ask another
// origin for leave first, which most static hosts do not answer.
import type { ByteFetcher, OpenOptions, Source } from "../api.js";
import { OctavoError } from "../errors.js";
import { platform } from "../platform/browser.js";

/** How a fetcher answers: more than was asked for where a host ignores ranges. */
export interface FetchedBytes {
  readonly bytes: Uint8Array;
  /** Length of the whole file, where the host tells. */
  readonly total?: number;
  /** `bytes` is the whole file. */
  readonly isWhole?: boolean;
}

/** Hears how many bytes of a request have come, of how many; NaN where nobody knows. */
export type OnBytes = (arrived: number, wanted: number) => void;

export interface Fetcher {
  readonly name: string;
  /** Of bytes at hand. */
  readonly size?: number;
  /** fresh  past all caches on the way */
  fetchBytes(
    offset: number, length: number, signal: AbortSignal, fresh: boolean, onBytes: OnBytes):
    Promise<FetchedBytes>;
}

/** A failure that may be over in a moment. */
export class Unsettled extends Error {
  constructor(message: string, readonly waitMs: number = 0) {
    super(message);
  }
}

/** An answer that ended well, and before the file does: of another file, perhaps. */
export class ShortAnswer extends Unsettled {}

export interface FetchSettings {
  readonly name?: string;
  readonly wholeFileBytes: number;
  readonly credentials: NonNullable<OpenOptions["credentials"]>;
}

/** Without a byte for so long a request is given up. */
const stallMs = 30_000;

const megabytes = (bytes: number): string => `${(bytes / 1e6).toFixed(bytes < 1e7 ? 1 : 0)} MB`;

/** The last part of a URL, for messages. */
function nameOfUrl(url: string): string {
  const path = url.replace(/[?#].*$/s, "");
  const last = path.slice(path.lastIndexOf("/") + 1) || url;
  try {
    return decodeURIComponent(last);
  } catch {
    return last;
  }
}

class UrlFetcher implements Fetcher {
  readonly name: string;

  constructor(readonly url: string, readonly settings: FetchSettings) {
    this.name = settings.name ?? nameOfUrl(url);
    const { username, password } = new URL(url);
    if (username !== "" || password !== "") {
      throw new OctavoError("invalid_argument",
        `${this.name}: browsers reject addresses with a name or password in them, ` +
        "user:password@host");
    }
  }

  async fetchBytes(
    offset: number, length: number, signal: AbortSignal, fresh: boolean,
    onBytes: OnBytes): Promise<FetchedBytes> {
    const stalled = new AbortController();
    const watch = new Watch(stalled, onBytes);
    const ending = chained(signal, stalled);
    let hasAnswered = false;
    try {
      const response = await this.ask(offset, length, ending, fresh);
      hasAnswered = true;
      if (response.status === 200) return await this.readWhole(response, watch);
      const range = /^bytes (\d+)-\d+\/(\d+)$/.exec(response.headers.get("Content-Range") ?? "");
      if (range && Number(range[1]) !== offset) {
        throw new OctavoError("io", `${this.name}: the server sent other bytes than asked for`);
      }
      const total = range ? Number(range[2]) : undefined;
      watch.wanted = Math.min(length, (total ?? Infinity) - offset);
      const bytes = await readBody(response, length, watch);
      if (bytes.length > length) {
        throw new OctavoError("io", `${this.name}: the server sent more bytes than asked for`);
      }
      if (total !== undefined && bytes.length < Math.min(length, total - offset)) {
        throw new Unsettled("the connection ended early");
      }
      return { bytes, ...(total === undefined ? {} : { total }) };
    } catch (cause) {
      if (signal.aborted || cause instanceof OctavoError || cause instanceof Unsettled) throw cause;
      if (stalled.signal.aborted) throw new Unsettled("the server stopped answering");
      if (hasAnswered) throw new Unsettled("the connection ended early");
      const { protocol } = new URL(this.url);
      if (!/^https?:$/.test(protocol)) {
        throw new OctavoError("io",
          `${this.name}: addresses of ${protocol} cannot be fetched here`, { cause });
      }
      throw await this.whyNoAnswer(ending);
    } finally {
      watch.end();
    }
  }

  /** Pages hear no more of a fetch than that it failed. */
  private async whyNoAnswer(signal: AbortSignal): Promise<Error> {
    const { credentials } = this.settings;
    // Without a range, of which browsers decode no part. Node.js reads compressed ranges.
    const head = platform.baseAddress() === undefined ? undefined
      : await fetch(this.url, { method: "HEAD", signal, credentials, cache: "no-store" })
        .catch(() => undefined);
    if (!head) {
      return new Unsettled(
        "the server cannot be reached, or does not let pages of other sites read it (CORS)");
    }
    const encoding = head.headers.get("Content-Encoding");
    if (encoding) {
      return new OctavoError("io",
        `${this.name}: the server compresses it (Content-Encoding: ${encoding}), and browsers ` +
        "read no ranges of that; it has to be served as it is");
    }
    return new Unsettled("the server is there, but its answer to a range cannot be read: the " +
      "connection ended early, or the range was compressed (Content-Encoding)");
  }

  private async ask(
    offset: number, length: number, signal: AbortSignal, fresh: boolean): Promise<Response> {
    const response = await fetch(this.url, {
      headers: { Range: `bytes=${offset}-${offset + length - 1}` },
      signal,
      credentials: this.settings.credentials,
      ...(fresh ? { cache: "reload" as const } : {}),
    });
    const { status } = response;
    if (status === 206 || status === 200) return response;
    void response.body?.cancel();
    if (status === 416) {
      throw endsBefore(this.name, offset);
    }
    const text = `the server answered ${status} ${response.statusText}`.trim();
    if (status >= 500 || status === 429 || status === 408) {
      const wait = Number(response.headers.get("Retry-After"));
      throw new Unsettled(text, Number.isFinite(wait) ? Math.min(wait, 30) * 1000 : 0);
    }
    throw new OctavoError("io", `${this.name}: ${text}`, { status });
  }

  /** The host sends all of the file whatever is asked for. */
  private async readWhole(response: Response, watch: Watch): Promise<FetchedBytes> {
    const most = this.settings.wholeFileBytes;
    // Of a compressed answer the length is another one.
    const length = response.headers.has("Content-Encoding")
      ? NaN : Number(response.headers.get("Content-Length") ?? NaN);
    const tooLarge = () => new OctavoError("no_ranges",
      `${this.name}: this server ignores ranges and sends the whole file each time; ` +
      `files above ${megabytes(most)} need a server that answers them, such as nginx or caddy`);
    if (length > most) {
      void response.body?.cancel();
      throw tooLarge();
    }
    watch.wanted = length;
    const bytes = await readBody(response, most, watch);
    if (bytes.length > most) throw tooLarge();
    if (bytes.length < length) throw new Unsettled("the connection ended early");
    return { bytes, total: bytes.length, isWhole: true };
  }
}

/** The controller's signal, aborted when `signal` is: AbortSignal.any, which browsers may lack. */
export function chained(signal: AbortSignal, controller: AbortController): AbortSignal {
  if (signal.aborted) controller.abort(signal.reason);
  signal.addEventListener("abort", () => controller.abort(signal.reason), {
    once: true, signal: controller.signal });
  return controller.signal;
}

/** Aborts what brings no byte for too long. */
class Watch {
  wanted = NaN;
  private timer: ReturnType<typeof setTimeout>;

  constructor(
    private readonly controller: AbortController, private readonly onBytes: OnBytes) {
    this.timer = this.start();
  }

  arrived(count: number): void {
    clearTimeout(this.timer);
    this.timer = this.start();
    this.onBytes(count, this.wanted);
  }

  end(): void {
    clearTimeout(this.timer);
  }

  private start(): ReturnType<typeof setTimeout> {
    return setTimeout(() => this.controller.abort(), stallMs);
  }
}

/** The bytes of an answer; a few more than `most` where there are more. */
async function readBody(
  response: Response, most: number, watch: Watch): Promise<Uint8Array<ArrayBuffer>> {
  const reader = response.body?.getReader();
  if (!reader) return new Uint8Array(await response.arrayBuffer());
  const parts: Uint8Array[] = [];
  let count = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    parts.push(value);
    count += value.length;
    watch.arrived(count);
    if (count > most) {
      void reader.cancel();
      break;
    }
  }
  const bytes = new Uint8Array(count);
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

class BlobFetcher implements Fetcher {
  readonly name: string;
  readonly size: number;

  constructor(private readonly blob: Blob, name?: string) {
    this.name = name ?? ("name" in blob ? String(blob.name) : "file");
    this.size = blob.size;
  }

  async fetchBytes(offset: number, length: number): Promise<FetchedBytes> {
    try {
      const part = this.blob.slice(offset, offset + length);
      return { bytes: new Uint8Array(await part.arrayBuffer()), total: this.size };
    } catch (cause) {
      throw new OctavoError("io",
        `${this.name}: cannot be read any more; was it changed or moved?`, { cause });
    }
  }
}

class MemoryFetcher implements Fetcher {
  readonly size: number;

  constructor(private readonly bytes: Uint8Array, readonly name: string) {
    this.size = bytes.length;
  }

  fetchBytes(offset: number, length: number): Promise<FetchedBytes> {
    return Promise.resolve({
      bytes: this.bytes.slice(offset, offset + length), total: this.size });
  }
}

/** An address as text, relative to the page; Node.js has none that it could count from. */
function addressOf(text: string): string {
  try {
    return new URL(text, platform.baseAddress()).href;
  } catch (cause) {
    throw new OctavoError("invalid_argument",
      `${text}: no address; of a file that is no server's give its bytes or a Blob`, { cause });
  }
}

/** A fetcher of the caller's, which gives fewer bytes than it is asked for where the file ends. */
function ownFetcher(source: ByteFetcher, settings: FetchSettings): Fetcher {
  const name = settings.name ?? source.name ?? "file";
  return {
    name,
    fetchBytes: async (offset, length, signal) => {
      const bytes = await source.fetchBytes(offset, length, signal);
      if (bytes.length >= length) return { bytes };
      if (bytes.length === 0 && offset > 0) throw endsBefore(name, offset);
      return { bytes, total: offset + bytes.length };
    },
  };
}

function endsBefore(name: string, offset: number): OctavoError {
  return new OctavoError("truncated", `${name}: ends before byte ${offset}`);
}

export function fetcherOf(source: Source, settings: FetchSettings): Fetcher {
  if (typeof source === "string") return new UrlFetcher(addressOf(source), settings);
  if (source instanceof URL) return new UrlFetcher(source.href, settings);
  if (source instanceof Blob) return new BlobFetcher(source, settings.name);
  if (source instanceof ArrayBuffer) {
    return new MemoryFetcher(new Uint8Array(source), settings.name ?? "bytes");
  }
  if (source instanceof Uint8Array) return new MemoryFetcher(source, settings.name ?? "bytes");
  // Programs without types may give anything.
  if (typeof (source as ByteFetcher | null)?.fetchBytes === "function") {
    return ownFetcher(source, settings);
  }
  throw new OctavoError("invalid_argument",
    `${settings.name ?? "file"}: no address, File, Blob, bytes or fetcher to open`);
}

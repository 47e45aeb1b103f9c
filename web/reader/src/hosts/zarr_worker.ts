// A Service Worker that answers for zarr hierarchies which no server has: of every scan.8vo below
// its folder it makes scan.8vo.zarr/, as hosts/zarr.ts says. Viewers that read OME-Zarr open .8vo
// files on a static host that way, unchanged.
//
//     navigator.serviceWorker.register("zarr-worker.js")       beside octavo.wasm
import type { Volume } from "../api.js";
import { LocalPool } from "../decode/local_pool.js";
import { OctavoError } from "../errors.js";
import { open } from "../volume/opening.js";
import { otherFile, valueOf } from "./zarr.js";

interface FetchEvent extends Event {
  readonly request: Request;
  respondWith(response: Promise<Response>): void;
}

interface WorkerScope {
  readonly location: Location;
  readonly clients: { claim(): Promise<void> };
  skipWaiting(): Promise<void>;
  addEventListener(type: string, hear: (event: FetchEvent) => void): void;
}

const scope = globalThis as unknown as WorkerScope;
const mark = ".8vo.zarr/";
/** Scans kept open. */
const mostScans = 4;

/** A scan that is open, and how many requests read it now. */
interface HeldScan {
  readonly volume: Promise<Volume>;
  readers: number;
}

let pool: Promise<LocalPool> | null = null;
const scans = new Map<string, HeldScan>();

function decoders(): Promise<LocalPool> {
  pool ??= LocalPool.create({ wasm: new URL("octavo.wasm", scope.location.href) });
  // The next one tries again.
  pool.catch(() => {
    pool = null;
  });
  return pool;
}

function heldScan(url: string): HeldScan {
  const held = scans.get(url) ?? {
    volume: decoders().then((own) => open(url, { pool: own })), readers: 0 };
  held.volume.catch(() => forget(url, held));
  scans.delete(url);
  scans.set(url, held);
  for (const [other, scan] of scans) {
    if (scans.size <= mostScans) break;
    forget(other, scan);
  }
  return held;
}

/** Closes a scan once nobody reads it; whoever comes next opens it anew. */
function forget(url: string, held: HeldScan): void {
  if (scans.get(url) === held) scans.delete(url);
  if (held.readers === 0) void held.volume.then((volume) => volume.close(), () => undefined);
}

async function valueOnce(url: string, key: string): Promise<Uint8Array<ArrayBuffer> | null> {
  const held = heldScan(url);
  held.readers += 1;
  try {
    return await valueOf(await held.volume, key);
  } catch (cause) {
    if (isReplaced(cause)) forget(url, held);
    throw cause;
  } finally {
    held.readers -= 1;
    if (scans.get(url) !== held) forget(url, held);
  }
}

const isReplaced = (cause: unknown): boolean =>
  cause instanceof OctavoError && cause.kind === "replaced" && cause.status !== otherFile;

/** Another file at the same place is opened anew, and looked for where somebody begins. */
async function valueAt(url: string, key: string): Promise<Uint8Array<ArrayBuffer> | null> {
  const known = scans.get(url);
  if (key === "zarr.json" && known) forget(url, known);
  try {
    return await valueOnce(url, key);
  } catch (cause) {
    if (!isReplaced(cause)) throw cause;
    return valueOnce(url, key);
  }
}

/** What a failure is to those who ask for a key. */
function statusOf(cause: unknown): number {
  if (!(cause instanceof OctavoError)) return 502;
  const { status = 502 } = cause;
  return [401, 403, 404, otherFile, 410].includes(status) ? status : 502;
}

async function answer(request: Request): Promise<Response> {
  const { origin, pathname } = new URL(request.url);
  const at = pathname.lastIndexOf(mark);
  const file = origin + pathname.slice(0, at + ".8vo".length);
  try {
    const value = await valueAt(file, pathname.slice(at + mark.length));
    if (value === null) return new Response("no such key", { status: 404 });
    return ranged(request, value);
  } catch (cause) {
    const text = cause instanceof Error ? cause.message : String(cause);
    return new Response(
      text, { status: statusOf(cause), headers: { "Content-Type": "text/plain" } });
  }
}

/** Some readers ask for a part of a value. */
function ranged(request: Request, value: Uint8Array<ArrayBuffer>): Response {
  const body = request.method === "HEAD" ? null : value;
  const headers = { "Content-Type": "application/octet-stream", "Cache-Control": "no-store" };
  const range = /^bytes=(\d+)-(\d*)$/.exec(request.headers.get("Range") ?? "");
  if (!range) {
    return new Response(body, { headers: { ...headers, "Content-Length": `${value.length}` } });
  }
  const first = Number(range[1]);
  const last = Math.min(range[2] ? Number(range[2]) : Infinity, value.length - 1);
  if (first > last) return new Response(null, { status: 416 });
  return new Response(value.slice(first, last + 1), {
    status: 206,
    headers: { ...headers, "Content-Range": `bytes ${first}-${last}/${value.length}` },
  });
}

scope.addEventListener("install", () => void scope.skipWaiting());
scope.addEventListener("activate", () => void scope.clients.claim());
scope.addEventListener("fetch", (event) => {
  const { method, url } = event.request;
  const { origin, pathname } = new URL(url);
  const isOwn = origin === scope.location.origin && pathname.includes(mark);
  if (isOwn && (method === "GET" || method === "HEAD")) event.respondWith(answer(event.request));
});

// A Service Worker that answers for zarr hierarchies which no server has: of every scan.8vo below
// its folder it makes scan.8vo.zarr/, as hosts/zarr.ts says. Viewers that read OME-Zarr open .8vo
// files on a static host that way, unchanged.
//
//     navigator.serviceWorker.register("zarr-worker.js")       beside octavo.wasm
import type { Volume } from "../api.js";
import { LocalPool } from "../decode/local_pool.js";
import { OctavoError } from "../errors.js";
import { open } from "../volume/opening.js";
import { valueOf } from "./zarr.js";

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

let pool: Promise<LocalPool> | null = null;
const scans = new Map<string, Promise<Volume>>();

function openOnce(url: string): Promise<Volume> {
  pool ??= LocalPool.create({ wasm: new URL("octavo.wasm", scope.location.href) });
  const own = pool;
  const opened = scans.get(url) ?? own.then((decoders) => open(url, { pool: decoders }));
  scans.delete(url);
  scans.set(url, opened);
  opened.catch(() => scans.delete(url));
  own.catch(() => {
    pool = null;
  });
  for (const [other, scan] of scans) {
    if (scans.size <= mostScans) break;
    scans.delete(other);
    void scan.then((volume) => volume.close());
  }
  return opened;
}

/** Another file at the same place is opened anew. */
async function valueAt(url: string, key: string): Promise<Uint8Array<ArrayBuffer> | null> {
  try {
    return await valueOf(await openOnce(url), key);
  } catch (cause) {
    if (!(cause instanceof OctavoError && cause.kind === "replaced")) throw cause;
    scans.delete(url);
    return valueOf(await openOnce(url), key);
  }
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
    return new Response(text, { status: 502, headers: { "Content-Type": "text/plain" } });
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

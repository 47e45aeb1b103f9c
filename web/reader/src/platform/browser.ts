// Browsers: pages, workers and Service Workers.
//
// Bundlers know worker.js and octavo.wasm by the very words `new Worker(new URL("...",
// import.meta.url)` and `new URL("...", import.meta.url)`, and bring the files along.
import type { ErrorKind } from "../api.js";
import { addressAt } from "../given.js";
import { fetchModule } from "./fetch_module.js";
import type { Platform, WorkerPort } from "./platform.js";

class BrowserWorker implements WorkerPort {
  constructor(private readonly worker: Worker, private readonly address: string) {}

  post(message: unknown, transfer: ArrayBuffer[] = []): void {
    this.worker.postMessage(message, transfer);
  }

  listen(hear: (message: unknown) => void): void {
    this.worker.addEventListener("message", (event) => hear(event.data));
  }

  onEnd(hear: (kind: ErrorKind, reason: string) => void): void {
    this.worker.addEventListener("error", ({ message }) => {
      // Browsers say nothing of a script that is not there, or is none.
      hear(message ? "internal" : "io", message || `is its script there? ${this.address}`);
    });
  }

  hold(): void {
    // Pages do not end by themselves.
  }

  end(): void {
    this.worker.terminate();
  }
}

const startAt = (address: string): Worker =>
  new Worker(address, { type: "module", name: "octavo" });

/** A worker of another origin: browsers start none, but one that imports it. */
function startFar(address: string): Worker {
  const script = new Blob([`import ${JSON.stringify(address)};`], { type: "text/javascript" });
  return startAt(URL.createObjectURL(script));
}

const isFar = (address: string): boolean =>
  /^https?:/.test(address) && !address.startsWith(`${location.origin}/`);

export const platform: Platform = {
  baseAddress: () => globalThis.document?.baseURI ?? globalThis.location?.href,
  coreCount: () => navigator.hardwareConcurrency || 4,
  startWorker(place) {
    const address = (place === undefined
      ? new URL("./worker.js", import.meta.url) : addressAt(place, platform.baseAddress())).href;
    const worker = isFar(address) ? startFar(address)
      : place !== undefined ? startAt(address)
        // Bundlers call what they make of it by that name.
        : new Worker(
          new URL("./worker.js", import.meta.url), { type: "module", name: "octavo-worker" });
    return new BrowserWorker(worker, address);
  },
  compile(place) {
    return fetchModule((place === undefined
      ? new URL("./octavo.wasm", import.meta.url) : addressAt(place, platform.baseAddress())).href);
  },
  expectListeners: () => undefined,
};

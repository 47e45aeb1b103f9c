// Node.js.
import { setMaxListeners } from "node:events";
import { readFile } from "node:fs/promises";
import { availableParallelism } from "node:os";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Worker } from "node:worker_threads";
import { OctavoError } from "../errors.js";
import { fetchModule } from "./fetch_module.js";
import type { Platform } from "./platform.js";

/** An address, or a path of this machine. */
function placeOf(place: string | URL): URL {
  if (place instanceof URL) return place;
  return /^[a-z][a-z\d+.-]+:/i.test(place) ? new URL(place) : pathToFileURL(resolve(place));
}

export const platform: Platform = {
  baseAddress: () => undefined,
  coreCount: availableParallelism,
  startWorker(place) {
    const worker = place === undefined
      ? new Worker(new URL("./worker-node.js", import.meta.url))
      : new Worker(placeOf(place));
    worker.unref();
    return {
      post: (message, transfer = []) => worker.postMessage(message, transfer),
      listen(hear) {
        worker.on("message", hear);
        worker.unref(); // Who listens for messages holds the program, too.
      },
      onEnd: (hear) => void worker.on("error", ({ message }) => hear("internal", message)),
      hold: (isHeld) => (isHeld ? worker.ref() : worker.unref()),
      end: () => void worker.terminate(),
    };
  },
  async compile(place) {
    const url = place === undefined
      ? new URL("./octavo.wasm", import.meta.url) : placeOf(place);
    if (url.protocol !== "file:") return fetchModule(url.href);
    try {
      return await WebAssembly.compile(await readFile(url));
    } catch (cause) {
      const reason = cause instanceof Error ? cause.message : String(cause);
      throw new OctavoError("io", `octavo.wasm: ${reason}`, { cause });
    }
  },
  expectListeners(signal) {
    if (signal instanceof EventTarget) setMaxListeners(0, signal);
  },
};

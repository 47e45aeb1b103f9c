// What browsers and Node.js do differently. browser.ts is what all sources see; build.mjs puts
// node.ts in its place for the scripts that Node.js runs.
import type { ErrorKind } from "../api.js";

export interface Port {
  post(message: unknown, transfer?: ArrayBuffer[]): void;
  listen(hear: (message: unknown) => void): void;
}

export interface WorkerPort extends Port {
  /** What is called when the worker cannot be started, or ends by itself. */
  onEnd(hear: (kind: ErrorKind, reason: string) => void): void;
  /** Whether a program goes on for it: not for idle workers. */
  hold(isHeld: boolean): void;
  end(): void;
}

export interface Platform {
  /** What addresses that callers write count from; undefined where nothing is. */
  baseAddress(): string | undefined;
  /** Cores of the machine. */
  coreCount(): number;
  /** Starts worker.js; the script at `place` where that is given. */
  startWorker(place: string | URL | undefined): WorkerPort;
  /** Compiles octavo.wasm; the file at `place` where that is given. */
  compile(place: string | URL | undefined): Promise<WebAssembly.Module>;
  /** A signal may have any number of listeners, without a word about it. */
  expectListeners(signal: AbortSignal): void;
}

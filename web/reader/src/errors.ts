// The one exception of this package.
import type { ErrorKind, OctavoFailure } from "./api.js";

export class OctavoError extends Error implements OctavoFailure {
  readonly kind: ErrorKind;
  readonly status?: number;

  constructor(
    kind: ErrorKind, message: string, options: { cause?: unknown; status?: number } = {}) {
    super(message, options);
    this.name = "OctavoError";
    this.kind = kind;
    if (options.status !== undefined) this.status = options.status;
  }
}

/** Any failure as one of this package; those of an AbortSignal are cancelled. */
export function failureOf(cause: unknown, name: string): OctavoError {
  if (cause instanceof OctavoError) return cause;
  const text = cause instanceof Error ? cause.message : String(cause);
  if (cause instanceof Error && cause.name === "AbortError") {
    return new OctavoError("cancelled", `${name}: cancelled`, { cause });
  }
  return new OctavoError("internal", `${name}: ${text}`, { cause });
}

/** What a signal that has aborted makes of those who wait. */
export function cancelled(name: string, signal?: AbortSignal): OctavoError {
  return new OctavoError("cancelled", `${name}: cancelled`, { cause: signal?.reason });
}

/** Rejects as soon as the signal aborts; `promise` goes on for others who wait for it. */
export function orCancelled<T>(
  promise: Promise<T>, name: string, signal?: AbortSignal): Promise<T> {
  if (!signal) return promise;
  if (signal.aborted) return Promise.reject(cancelled(name, signal));
  return new Promise<T>((resolve, reject) => {
    const stop = () => reject(cancelled(name, signal));
    signal.addEventListener("abort", stop, { once: true });
    const done = () => signal.removeEventListener("abort", stop);
    promise.then(
      (value) => { done(); resolve(value); },
      (cause: unknown) => {
        done();
        reject(failureOf(cause, name));
      });
  });
}

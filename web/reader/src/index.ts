// @octavo/reader: .8vo files in browsers and Node.js.
import type { CreatePool } from "./api.js";
import { LocalPool } from "./decode/local_pool.js";
import { WorkerPool } from "./decode/pool.js";
import { failureOf, OctavoError } from "./errors.js";
import { countOr, requirePlace } from "./given.js";

export type * from "./api.js";
export { OctavoError } from "./errors.js";
export { open } from "./volume/opening.js";

export const createPool: CreatePool = async (options) => {
  const workers = options?.workers ?? 1;
  if (!Number.isInteger(workers) || workers < 0) {
    throw new OctavoError("invalid_argument", `a pool of ${String(workers)} workers`);
  }
  countOr(0, options?.cacheBytes, "cacheBytes");
  requirePlace(options?.worker, "worker");
  if (!(options?.wasm instanceof WebAssembly.Module)) requirePlace(options?.wasm, "wasm");
  try {
    return await (workers === 0 ? LocalPool : WorkerPool).create(options);
  } catch (cause) {
    throw failureOf(cause, "pool");
  }
};

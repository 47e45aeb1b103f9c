// @octavo/reader: .8vo files in browsers and Node.js.
import type { CreatePool } from "./api.js";
import { LocalPool } from "./decode/local_pool.js";
import { WorkerPool } from "./decode/pool.js";

export type * from "./api.js";
export { OctavoError } from "./errors.js";
export { open } from "./volume/opening.js";

export const createPool: CreatePool = (options) =>
  (options?.workers === 0 ? LocalPool : WorkerPool).create(options);

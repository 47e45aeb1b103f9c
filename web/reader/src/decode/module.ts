// octavo.wasm, compiled once for all workers.
import { platform } from "../platform/browser.js";

/** place  where it is, or the module itself; beside this script where absent */
export function compile(
  place: string | URL | WebAssembly.Module | undefined): Promise<WebAssembly.Module> {
  return place instanceof WebAssembly.Module ? Promise.resolve(place) : platform.compile(place);
}

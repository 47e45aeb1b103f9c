// octavo.wasm, compiled once for all workers.
import { OctavoError } from "../errors.js";
import { isNode } from "./ports.js";

export async function compile(
  wasm: string | URL | WebAssembly.Module): Promise<WebAssembly.Module> {
  if (wasm instanceof WebAssembly.Module) return wasm;
  const url = new URL(wasm, import.meta.url);
  if (isNode && url.protocol === "file:") {
    const { readFile } = await import("node:fs/promises");
    return WebAssembly.compile(await readFile(url));
  }
  const response = await fetch(url, { credentials: "same-origin" });
  if (!response.ok) {
    throw new OctavoError("io", `octavo.wasm: the server answered ${response.status}`);
  }
  // Hosts that do not know the type of .wasm are taken, too.
  if (response.headers.get("Content-Type") === "application/wasm") {
    return WebAssembly.compileStreaming(response);
  }
  return WebAssembly.compile(await response.arrayBuffer());
}

// octavo.wasm from a server.
import { OctavoError } from "../errors.js";

/** Rejects with kind io and the address where none is there. */
export async function fetchModule(address: string): Promise<WebAssembly.Module> {
  const failed = (reason: string, cause?: unknown) =>
    new OctavoError("io", `octavo.wasm: ${reason}: ${address}`, { cause });
  let response: Response;
  try {
    response = await fetch(address, { credentials: "same-origin" });
  } catch (cause) {
    throw failed("the server cannot be reached", cause);
  }
  if (!response.ok) throw failed(`the server answered ${response.status}`);
  try {
    // Hosts that do not know the type of .wasm are taken, too.
    if (response.headers.get("Content-Type") === "application/wasm") {
      return await WebAssembly.compileStreaming(response);
    }
    return await WebAssembly.compile(await response.arrayBuffer());
  } catch (cause) {
    // Some servers send a page in place of what they do not have.
    throw failed("no WebAssembly is there", cause);
  }
}

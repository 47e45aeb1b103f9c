// A worker: decodes boxes of the files that the page has opened, one job after the other.
//
// It has no bytes but those that the page sends. What a job lacks it asks for, again until nothing
// is missing.
import { failureOf } from "../errors.js";
import { EngineFile } from "./engine.js";
import type { FromWorker, ToWorker } from "./messages.js";
import { voxelsOf } from "./reading.js";
import { warm } from "./warming.js";
import type { Port } from "../platform/platform.js";

type ReadJob = Extract<ToWorker, { kind: "read" }>;
type SentBytes = Extract<ToWorker, { kind: "bytes" }>["parts"];

const files = new Map<number, EngineFile>();
const waiting = new Map<number, (parts: SentBytes) => void>();
let module: WebAssembly.Module | null = null;

let send: (message: FromWorker, transfer?: ArrayBuffer[]) => void;

function bytesFor(job: number, ranges: Extract<FromWorker, { kind: "needs" }>["ranges"]) {
  return new Promise<SentBytes>((resolve) => {
    waiting.set(job, resolve);
    send({ kind: "needs", job, ranges });
  });
}

async function read(job: ReadJob): Promise<void> {
  const file = files.get(job.file);
  const started = performance.now();
  try {
    if (!file) throw new Error("the file is closed");
    const voxels = await voxelsOf(file, job, (ranges) => bytesFor(job.job, ranges));
    if (voxels === null) {
      send({ kind: "failed", job: job.job, error: "cancelled", message: "cancelled" });
      return;
    }
    send({ kind: "voxels", job: job.job, voxels, ms: performance.now() - started }, [voxels]);
  } catch (cause) {
    const { kind, message } = failureOf(cause, file?.opening.name ?? "file");
    send({ kind: "failed", job: job.job, error: kind, message });
  }
}

function hear(said: ToWorker): void {
  switch (said.kind) {
    case "start":
      module = said.module;
      if (said.isWarming) void warm(module);
      break;
    case "open":
      files.set(said.file, new EngineFile(module!, said.opening));
      break;
    case "close":
      files.delete(said.file);
      break;
    case "read":
      void read(said);
      break;
    case "bytes":
      waiting.get(said.job)?.(said.parts);
      waiting.delete(said.job);
      break;
  }
}

/** Does what the page at the other side of `port` asks for. */
export function serve(port: Port): void {
  send = (message, transfer = []) => port.post(message, transfer);
  port.listen((message) => hear(message as ToWorker));
}

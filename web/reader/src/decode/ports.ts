// Workers of browsers and of Node.js behind one interface.

export interface Port {
  post(message: unknown, transfer?: ArrayBuffer[]): void;
  listen(hear: (message: unknown) => void): void;
}

export interface WorkerPort extends Port {
  /** What is called when the worker cannot be started, or ends by itself. */
  onEnd(hear: (reason: string) => void): void;
  /** Whether a program goes on for it: not for idle workers. */
  hold(isHeld: boolean): void;
  end(): void;
}

interface NodeProcess {
  readonly versions?: { readonly node?: string };
}

export const isNode =
  (globalThis as { process?: NodeProcess }).process?.versions?.node !== undefined &&
  typeof (globalThis as { Worker?: unknown }).Worker === "undefined";

/** The side of the worker. */
export async function portOfWorker(): Promise<Port> {
  if (typeof self !== "undefined" && typeof self.postMessage === "function") {
    return {
      post: (message, transfer = []) => self.postMessage(message, { transfer }),
      listen: (hear) => self.addEventListener("message", (event) => hear(event.data)),
    };
  }
  const { parentPort } = await import("node:worker_threads");
  return {
    post: (message, transfer = []) => parentPort!.postMessage(message, transfer),
    listen: (hear) => void parentPort!.on("message", hear),
  };
}

/** The side of the page. */
export async function startWorker(url: URL): Promise<WorkerPort> {
  if (!isNode) return new BrowserWorker(new Worker(url, { type: "module", name: "octavo" }));
  const { Worker: NodeWorker } = await import("node:worker_threads");
  const worker = new NodeWorker(url);
  worker.unref();
  return {
    post: (message, transfer = []) => worker.postMessage(message, transfer),
    listen: (hear) => void worker.on("message", hear),
    onEnd: (hear) => {
      worker.on("error", (error) => hear(error.message));
    },
    hold: (isHeld) => (isHeld ? worker.ref() : worker.unref()),
    end: () => void worker.terminate(),
  };
}

class BrowserWorker implements WorkerPort {
  constructor(private readonly worker: Worker) {}

  post(message: unknown, transfer: ArrayBuffer[] = []): void {
    this.worker.postMessage(message, transfer);
  }

  listen(hear: (message: unknown) => void): void {
    this.worker.addEventListener("message", (event) => hear(event.data));
  }

  onEnd(hear: (reason: string) => void): void {
    this.worker.addEventListener("error", (event) => hear(event.message || "it did not start"));
  }

  hold(): void {
    // Pages do not end by themselves.
  }

  end(): void {
    this.worker.terminate();
  }
}

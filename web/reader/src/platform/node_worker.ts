// worker-node.js: what Node.js runs.
import { parentPort } from "node:worker_threads";
import { serve } from "../decode/worker.js";

serve({
  post: (message, transfer = []) => parentPort!.postMessage(message, transfer),
  listen: (hear) => void parentPort!.on("message", hear),
});

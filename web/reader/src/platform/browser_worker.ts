// worker.js: what browsers run.
import { serve } from "../decode/worker.js";

serve({
  post: (message, transfer = []) => self.postMessage(message, { transfer }),
  listen: (hear) => self.addEventListener("message", (event) => hear(event.data)),
});

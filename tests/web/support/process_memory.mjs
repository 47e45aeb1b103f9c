// Memory of the processes of a browser that this one has started.
import { readFileSync, readdirSync } from "node:fs";

/** Bytes in memory of processes whose command line has a word; 0 where none is there. */
export function memoryOf(word) {
  const parents = new Map();
  const sizes = new Map();
  for (const id of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const status = readFileSync(`/proc/${id}/status`, "utf8");
      parents.set(id, /PPid:\s+(\d+)/.exec(status)[1]);
      if (!readFileSync(`/proc/${id}/cmdline`, "utf8").includes(word)) continue;
      sizes.set(id, Number(/RssAnon:\s+(\d+)/.exec(status)?.[1] ?? 0) * 1024);
    } catch {
      // It has ended meanwhile.
    }
  }
  const isOwn = (id) => id !== undefined && (id === `${process.pid}` || isOwn(parents.get(id)));
  return [...sizes].reduce((sum, [id, size]) => (isOwn(id) ? sum + size : sum), 0);
}

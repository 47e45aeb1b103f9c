// Every level of every golden file in Node.js: the SHA-1 of what the program extracts.
import assert from "node:assert/strict";
import { join } from "node:path";
import { test } from "node:test";
import { dist, golden, goldenNames, programDigests, sha1 } from "./support/golden.mjs";

const { createPool, open } = await import(join(dist, "reader-node.js"));

test("every level of every golden file has the voxels of the program", async () => {
  const pool = await createPool({ workers: 2 });
  const expected = await programDigests();
  assert.deepEqual(Object.keys(expected), goldenNames());
  for (const name of goldenNames()) {
    const scan = await open(golden(name), { name, pool });
    const found = [];
    for (const { level, size } of scan.levels) {
      const voxels = await scan.read({ lo: [0, 0, 0], hi: size }, level);
      found.push(sha1(new Uint8Array(voxels.buffer)));
    }
    assert.deepEqual(found, expected[name], name);
    scan.close();
  }
  pool.close();
});

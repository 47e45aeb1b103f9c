// @octavo/reader in Node.js: the voxels of the program, few requests, and every kind of bad luck.
//
// usage: OCTAVO=build/octavo node tests/web/reader_test.mjs
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import {
  builtScan, crc32c, dist, exportedNifti, golden, goldenFolder, goldenNames, listedChecksums, run, sha1,
} from "./support/golden.mjs";
import { damagedFiles } from "./support/damage.mjs";
import { beginRange, startServer } from "./support/server.mjs";

const { createPool, open, OctavoError } = await import(join(dist, "reader-node.js"));

let pool;
let host;
before(async () => {
  pool = await createPool({ workers: 2 });
  host = await startServer();
});
after(async () => {
  pool.close();
  await host.close();
});

const whole = (level) => ({ lo: [0, 0, 0], hi: level.size });
const bytesOf = (voxels) => new Uint8Array(voxels.buffer);

/** A file on the host; the log starts anew. */
function serve(bytes, path = "/scan.8vo") {
  host.files.set(path, Buffer.from(bytes));
  host.log.length = 0;
  host.misbehave = null;
  host.ignoresRanges = false;
  host.headers = {};
  return host.url + path;
}

const failsWith = (kind, words) => (error) => {
  assert.ok(error instanceof OctavoError, String(error));
  assert.equal(error.kind, kind, error.message);
  assert.match(error.message, words);
  assert.doesNotMatch(error.message, /\n/);
  return true;
};

test("every level of every golden file has the voxels that the library gives", async () => {
  const expected = listedChecksums();
  for (const [name, checksums] of Object.entries(expected)) {
    const scan = await open(golden(name), { name, pool });
    const found = [];
    for (const level of scan.levels) {
      found.push(crc32c(bytesOf(await scan.read(whole(level), level.level))));
    }
    assert.deepEqual(found, checksums, name);
    scan.close();
  }
});

test("any box is a part of its level", async () => {
  for (const name of ["slices-fast.8vo", "cut-xz.8vo", "three-tiers.8vo", "labels-uint8.8vo"]) {
    const url = serve(golden(name));
    const scan = await open(url, { pool });
    const level = scan.levels[0];
    const all = await scan.read(whole(level), 0);
    let seed = 7;
    const random = (below) => (seed = (seed * 48271) % 2147483647) % below;
    for (let i = 0; i < 12; ++i) {
      const lo = level.size.map(random);
      const hi = level.size.map((size, axis) => lo[axis] + 1 + random(size - lo[axis]));
      const part = await scan.read({ lo, hi }, 0);
      const [w, h, d] = hi.map((end, axis) => end - lo[axis]);
      for (let n = 0; n < 200; ++n) {
        const [x, y, z] = [random(w), random(h), random(d)];
        const at = ((lo[2] + z) * level.size[1] + lo[1] + y) * level.size[0] + lo[0] + x;
        assert.equal(part[(z * h + y) * w + x], all[at], `${name} ${lo} ${hi}`);
      }
    }
    scan.close();
  }
});

test("what a file says of itself is what the program says", async () => {
  for (const name of goldenNames()) {
    const scan = await open(golden(name), { name, pool });
    const said = JSON.parse(run("info", join(goldenFolder, name), "--json"));
    assert.deepEqual([...scan.size], said.size);
    assert.equal(scan.kind, said.kind);
    assert.equal(scan.type, said.type);
    assert.deepEqual([...scan.spacingMm], said.spacing_mm);
    assert.deepEqual([...scan.originMm], said.origin_mm);
    assert.deepEqual([...scan.direction], said.direction);
    assert.equal(scan.slope, said.rescale.slope);
    assert.equal(scan.isSpacingKnown, said.spacing_known);
    assert.equal(scan.byteLength, golden(name).length);
    scan.levels.forEach((level, i) => {
      assert.deepEqual([...level.size], said.levels[i].size);
      assert.deepEqual([...level.spacingMm], said.levels[i].spacing_mm);
    });
    scan.close();
  }
});

test("values, places and o-codes are those of the program", async () => {
  const name = "small-int16.8vo";
  const scan = await open(golden(name), { name, pool });
  for (const voxel of [[0, 0, 0], [1, 2, 3], scan.size.map((size) => size - 1)]) {
    const [said] = JSON.parse(
      run("probe", join(goldenFolder, name), "--at", voxel.join(","), "--json")).points;
    const box = { lo: voxel, hi: voxel.map((at) => at + 1) };
    assert.equal((await scan.read(box, 0))[0], said.stored);
    assert.equal(scan.oCode(voxel), said.o_code.mixed_octal);
    assert.deepEqual([...scan.toWorld(voxel)], said.world_mm);
    const back = scan.toIndex(scan.toWorld(voxel));
    back.forEach((at, axis) => assert.ok(Math.abs(at - voxel[axis]) < 1e-9));
  }
  const real = await scan.readReal({ lo: [0, 0, 0], hi: [2, 2, 2] }, 0);
  const stored = await scan.read({ lo: [0, 0, 0], hi: [2, 2, 2] }, 0);
  real.forEach((value, i) => assert.equal(value, Math.fround(scan.toReal(stored[i]))));
  assert.throws(() => scan.oCode([0, 0, scan.size[2]]), failsWith("invalid_argument", /no voxel/));
  scan.close();
});

test("ranges of bricks hold their voxels", async () => {
  for (const name of ["small-two-tiers.8vo", "small-gaps.8vo", "labels-uint8.8vo"]) {
    const scan = await open(golden(name), { name, pool });
    const [level] = scan.levels;
    const grid = { lo: [0, 0, 0], hi: level.brickGrid };
    const { min, max } = await scan.brickRanges(grid, 0);
    let at = 0;
    for (let z = 0; z < level.brickGrid[2]; ++z) {
      for (let y = 0; y < level.brickGrid[1]; ++y) {
        for (let x = 0; x < level.brickGrid[0]; ++x, ++at) {
          const lo = [x, y, z].map((n, axis) => n * level.brickSide[axis]);
          const hi = lo.map((n, axis) => Math.min(n + level.brickSide[axis], level.size[axis]));
          const voxels = await scan.read({ lo, hi }, 0);
          assert.equal(voxels.reduce((a, b) => Math.min(a, b)), min[at]);
          assert.equal(voxels.reduce((a, b) => Math.max(a, b)), max[at]);
        }
      }
    }
    scan.close();
  }
});

test("opening takes two requests, and asks for plain ranges alone", async () => {
  const url = serve(golden("float32-exact.8vo"));
  const scan = await open(url, { pool });
  await scan.read(whole(scan.levels[2]), 2);
  await scan.read(whole(scan.levels[0]), 0);
  assert.ok(host.log.length <= 2, JSON.stringify(host.log));
  for (const { method, range, headers } of host.log) {
    assert.equal(method, "GET");
    assert.match(range, /^bytes=\d+-\d+$/);
    assert.equal(headers["if-range"], undefined);
  }
  assert.equal(scan.statistics.requests, host.log.length);
  scan.close();
});

test("a plan says what is needed and what is here", async () => {
  const url = serve(golden("small-int16.8vo"));
  const scan = await open(url, { pool, cacheBytes: 1 << 20 });
  const before = await scan.plan(whole(scan.levels[0]), 0);
  assert.ok(before.isComplete);
  await scan.read(whole(scan.levels[0]), 0);
  const later = await scan.plan(whole(scan.levels[0]), 0);
  assert.equal(later.neededBytes, before.neededBytes);
  assert.equal(later.presentBytes, later.neededBytes);
  assert.equal(later.requests, 0);
  scan.close();
});

test("200 damaged files: a sentence each, and the next file still opens", async () => {
  const sound = golden("small-int16.8vo");
  const expected = sha1(bytesOf(await (async () => {
    const scan = await open(sound, { pool });
    return scan.read(whole(scan.levels[0]), 0);
  })()));
  let failures = 0;
  for (const { name, bytes } of damagedFiles(goldenNames().map((one) => [one, golden(one)]), 200)) {
    try {
      const scan = await open(bytes, { name, pool });
      for (const level of scan.levels) await scan.read(whole(level), level.level);
      scan.close();
    } catch (error) {
      failures += 1;
      failsWith(error.kind, /^[^\n]{8,400}$/)(error);
      assert.notEqual(error.kind, "internal", error.message);
    }
  }
  assert.ok(failures > 150, `${failures} of 200 were found out`);
  const scan = await open(sound, { pool });
  assert.equal(sha1(bytesOf(await scan.read(whole(scan.levels[0]), 0))), expected);
  scan.close();
});

test("a host that ignores ranges sends small files whole, and says so", async () => {
  const url = serve(golden("small-int16.8vo"));
  host.ignoresRanges = true;
  const scan = await open(url, { pool });
  assert.match(scan.hostNote, /ignores ranges/);
  await scan.read(whole(scan.levels[0]), 0);
  assert.equal(host.log.length, 1);
  scan.close();
  await assert.rejects(open(url, { pool, wholeFileBytes: 1000 }),
    failsWith("no_ranges", /ignores ranges/));
});

test("bytes that arrive damaged are asked for once more", async () => {
  const bytes = golden("small-int16.8vo");
  const url = serve(bytes);
  const spoiled = Buffer.from(bytes);
  spoiled[2000] ^= 4;
  host.files.set("/scan.8vo", spoiled);
  host.misbehave = () => {
    // Sound from the second request on.
    if (host.log.length > 1) host.files.set("/scan.8vo", Buffer.from(bytes));
    return false;
  };
  const scan = await open(url, { pool });
  await scan.read(whole(scan.levels[0]), 0);
  scan.close();
});

test("bytes that stay damaged are named", async () => {
  const bytes = golden("small-int16.8vo").slice();
  bytes[20000] ^= 4;
  const scan = await open(serve(bytes), { pool });
  await assert.rejects(scan.read(whole(scan.levels[0]), 0),
    failsWith("corrupt", /scan\.8vo: .*at byte \d+/));
  // Coarse levels do not need those bytes.
  await scan.read(whole(scan.levels[3]), 3);
  scan.close();
});

test("a file that takes another one's place is noticed, and no voxels mix", async () => {
  const [first, second] = [await builtScan(1), await builtScan(2)];
  const url = serve(first.bytes);
  const scan = await open(url, { pool });
  const kept = await scan.read(whole(scan.levels[5]), 5);
  assert.ok(kept.length > 0);
  serve(second.bytes);
  const replaced = failsWith("replaced", /another file/);
  await assert.rejects(scan.read(whole(scan.levels[0]), 0), replaced);
  await assert.rejects(scan.read(whole(scan.levels[5]), 5), replaced);
  const again = await scan.reopen();
  assert.notEqual(again.buildId, scan.buildId);
  assert.deepEqual(await again.read(whole(again.levels[0]), 0), second.voxels);
  again.close();
});

test("a large box takes few requests, in halves where it does not fit", async () => {
  const { bytes, voxels } = await builtScan(3);
  assert.ok(bytes.length > 9e5);
  const scan = await open(serve(bytes), { pool });
  assert.deepEqual(await scan.read(whole(scan.levels[0]), 0), voxels);
  assert.ok(host.log.length <= 4, JSON.stringify(host.log));
  scan.close();
  const small = await open(serve(bytes), { pool, cacheBytes: 700_000 });
  assert.deepEqual(await small.read(whole(small.levels[0]), 0), voxels);
  assert.ok(small.statistics.cachedBytes <= 700_000);
  small.close();
});

test("a server that fails for a while is asked again, one that is gone is named", async () => {
  const url = serve(golden("small-int16.8vo"));
  let failures = 0;
  host.misbehave = (request, response) => {
    if (failures++ >= 2) return false;
    if (failures === 1) response.destroy();
    else response.writeHead(503).end();
    return true;
  };
  const scan = await open(url, { pool });
  await scan.read(whole(scan.levels[0]), 0);
  assert.equal(scan.statistics.retries, 2);
  scan.close();
  host.files.delete("/scan.8vo");
  await assert.rejects(open(url, { pool }), failsWith("io", /scan\.8vo: .*404/));
});

test("a server that trickles bytes is waited for", async () => {
  const bytes = golden("small-int16.8vo");
  const url = serve(bytes);
  const calm = await open(url, { pool });
  const expected = await calm.read(whole(calm.levels[0]), 0);
  calm.close();
  let pieces = 0;
  host.misbehave = async (request, response) => {
    const part = beginRange(request, response, bytes);
    // A few bytes, and then ever more: frames of every size.
    for (let at = 0, n = 1; at < part.length; at += n, n = Math.min(2 * n, 700), ++pieces) {
      response.write(part.subarray(at, at + n));
      await new Promise((resolve) => setTimeout(resolve, 2));
    }
    response.end();
    return true;
  };
  const scan = await open(url, { pool });
  assert.deepEqual(await scan.read(whole(scan.levels[0]), 0), expected);
  assert.ok(pieces > 30, `${pieces}`);
  assert.equal(scan.statistics.retries, 0);
  scan.close();
});

test("a server that trickles for ever is said to be slow, and can be asked again", async () => {
  const bytes = golden("small-int16.8vo");
  const url = serve(bytes);
  host.misbehave = async (request, response) => {
    if (host.log.length > 1) return false;
    const part = beginRange(request, response, bytes);
    for (let at = 0; !response.destroyed && at < part.length; at += 10) {
      response.write(part.subarray(at, at + 10));
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
    return true;
  };
  const told = [];
  const scan = await open(url, {
    pool,
    onSlow: (slow) => {
      told.push(slow);
      if (told.length === 1) slow.askAgain();
    },
  });
  await scan.read(whole(scan.levels[0]), 0);
  assert.ok(told[0].arrivedBytes > 0 && told[0].arrivedBytes < bytes.length, JSON.stringify(told));
  assert.equal(told[0].wantedBytes, bytes.length);
  assert.ok(told[0].seconds >= 5);
  assert.equal(told.at(-1), null);
  assert.equal(scan.statistics.retries, 1);
  scan.close();
});

test("an answer that ends early is no file that ends early", async () => {
  const bytes = golden("small-int16.8vo");
  const url = serve(bytes);
  let cuts = 0;
  host.misbehave = (request, response) => {
    if (cuts++ > 0) return false;
    response.writeHead(206, { "Content-Length": 4096,
      "Content-Range": `bytes 0-4095/${bytes.length}` });
    response.write(Buffer.from(bytes.subarray(0, 100)));
    setTimeout(() => response.destroy(), 20);
    return true;
  };
  const scan = await open(url, { pool });
  await scan.read(whole(scan.levels[0]), 0);
  scan.close();
  const cutting = host.misbehave;
  host.misbehave = (request, response) => {
    cuts = 0;
    return cutting(request, response);
  };
  await assert.rejects(open(url, { pool }),
    failsWith("io", /scan\.8vo: the connection ended early; tried \d times/));
});

test("a signal ends what waits, and nothing else", async () => {
  const url = serve(golden("small-int16.8vo"));
  const controller = new AbortController();
  host.misbehave = () => new Promise((resolve) => setTimeout(() => resolve(false), 50));
  const given = open(url, { pool, signal: controller.signal });
  const kept = open(url, { pool });
  controller.abort();
  await assert.rejects(given, failsWith("cancelled", /cancelled/));
  const scan = await kept;
  const reading = new AbortController();
  const one = scan.read(whole(scan.levels[0]), 0, { signal: reading.signal });
  const other = scan.read(whole(scan.levels[0]), 0);
  reading.abort();
  await assert.rejects(one, failsWith("cancelled", /cancelled/));
  assert.equal((await other).length, scan.size[0] * scan.size[1] * scan.size[2]);
  scan.close();
  await assert.rejects(scan.read(whole(scan.levels[0]), 0), failsWith("closed", /closed/));
});

test("files, blobs and fetchers open as URLs do", async () => {
  const name = "labels-uint8.8vo";
  const bytes = golden(name);
  const expected = sha1(bytesOf(await (async () => {
    const scan = await open(bytes, { pool });
    return scan.read(whole(scan.levels[0]), 0);
  })()));
  const fetcher = {
    name: "mine",
    fetchBytes: async (offset, length) => bytes.slice(offset, offset + length),
  };
  for (const source of [new Blob([bytes]), bytes.buffer, fetcher, new URL(serve(bytes))]) {
    const scan = await open(source, { pool });
    assert.equal(sha1(bytesOf(await scan.read(whole(scan.levels[0]), 0))), expected);
    assert.equal(scan.kind, "labels");
    const info = scan.labelInfo(3);
    assert.equal(info.label, 3);
    assert.equal(info.color.length, 3);
    scan.close();
  }
});

test("a thumbnail is the picture that the program writes", async () => {
  const scan = await open(golden("thumbnail.8vo"), { pool });
  const picture = await scan.thumbnail();
  const bytes = new Uint8Array(await picture.arrayBuffer());
  assert.deepEqual([...bytes.subarray(1, 4)], [...Buffer.from("PNG")]);
  scan.close();
  const plain = await open(golden("small-int16.8vo"), { pool });
  assert.equal(await plain.thumbnail(), null);
  plain.close();
});

test("a NIfTI file for niivue is the one that the program exports", async () => {
  const { niftiOf } = await import(join(dist, "niivue-node.js"));
  const golds = ["small-int16.8vo", "small-axis-order.8vo", "float32-plain.8vo"].map(golden);
  for (const bytes of [...golds, (await builtScan(4)).bytes]) {
    const scan = await open(bytes, { pool });
    const own = new DataView(await niftiOf(scan, 1));
    const exported = await exportedNifti(bytes, 1);
    assert.equal(own.byteLength, exported.byteLength);
    for (let i = 40; i < 56; i += 2) assert.equal(own.getInt16(i, true), exported.getInt16(i, true));
    for (const at of [70, 72, 254]) assert.equal(own.getInt16(at, true), exported.getInt16(at, true));
    for (let at = 280; at < 328; at += 4) {
      assert.ok(Math.abs(own.getFloat32(at, true) - exported.getFloat32(at, true)) < 1e-5);
    }
    assert.equal(sha1(new Uint8Array(own.buffer, 352)),
      sha1(new Uint8Array(exported.buffer, exported.byteOffset + 352, exported.byteLength - 352)));
    scan.close();
  }
});

test("what is not there to be read is an error of its own", async () => {
  const scan = await open(golden("small-int16.8vo"), { name: "scan", pool });
  const outside = { lo: [0, 0, 0], hi: scan.size.map((size) => size + 1) };
  await assert.rejects(scan.read(outside, 0), failsWith("invalid_argument", /scan: the box/));
  await assert.rejects(scan.read(whole(scan.levels[0]), 99),
    failsWith("invalid_argument", /level 99/));
  scan.close();
  await assert.rejects(open(new Uint8Array(100000), { name: "zeros", pool }),
    failsWith("not_octavo", /zeros/));
  await assert.rejects(open(new Uint8Array(0), { name: "nothing", pool }), OctavoError);
  const text = readFileSync(join(goldenFolder, "levels.txt"));
  await assert.rejects(open(new Uint8Array(text), { name: "levels.txt", pool }),
    failsWith("not_octavo", /levels\.txt/));
});

test("whatever is no box, place, pool or source is an error of this package", async () => {
  const scan = await open(golden("small-int16.8vo"), { name: "scan", pool });
  const wrong = failsWith("invalid_argument", /./);
  for (const box of [null, undefined, {}, 5, { lo: [0, 0], hi: [1, 1] }, { lo: "abc", hi: null }]) {
    await assert.rejects(scan.read(box, 0), wrong);
    await assert.rejects(scan.plan(box, 0), wrong);
    await assert.rejects(scan.brickRanges(box, 0), wrong);
  }
  for (const level of [null, undefined, "length", 0.5, -1, {}]) {
    await assert.rejects(scan.read(whole(scan.levels[0]), level), wrong);
  }
  for (const place of [null, {}, [1, 2], "123", ["1", "2", "3"]]) {
    for (const call of ["oCode", "toWorld", "toIndex"]) {
      assert.throws(() => scan[call](place), wrong);
    }
  }
  const highest = Math.log2(Math.max(...scan.size) - 1) | 0;
  assert.equal(scan.oCode([0, 0, 0], highest + 1).replaceAll("8", ""), "");
  for (const level of [highest + 2, 40, -1, 0.5, NaN, "1"]) {
    assert.throws(() => scan.oCode([0, 0, 0], level),
      failsWith("invalid_argument", /^scan: no cubes of level .*; the whole is one of level \d+$/));
  }
  await assert.rejects(scan.read(whole(scan.levels[0]), 0, { signal: 3 }), wrong);
  scan.close();
  for (const source of [null, undefined, 5, {}, "d/x.8vo", "", { fetchBytes: 1 }]) {
    await assert.rejects(open(source, { pool }), wrong);
  }
  const bytes = golden("minimal.8vo");
  for (const option of ["cacheBytes", "parallelRequests", "joinGapBytes", "wholeFileBytes"]) {
    for (const given of [-1, NaN, "5", {}]) {
      await assert.rejects(open(bytes, { pool, [option]: given }),
        failsWith("invalid_argument", new RegExp(`^${option} is .*, no number from 0 on$`)));
    }
  }
  await assert.rejects(open(bytes, { pool: 3 }), wrong);
  for (const wasm of [42, {}, null, true]) {
    await assert.rejects(createPool({ wasm }), failsWith("invalid_argument", /^wasm is /));
  }
  await assert.rejects(createPool({ worker: 42 }), failsWith("invalid_argument", /^worker is /));
  for (const cacheBytes of [-1, NaN, "5"]) {
    await assert.rejects(createPool({ cacheBytes }), failsWith("invalid_argument", /^cacheBytes /));
  }
  await assert.rejects(open("ftp://127.0.0.1/x.8vo", { pool }),
    failsWith("io", /x\.8vo: .*ftp:.* cannot be fetched/));
  for (const workers of [-1, 1.5, "2", NaN]) await assert.rejects(createPool({ workers }), wrong);
  await assert.rejects(createPool({ wasm: "/no/octavo.wasm" }),
    failsWith("io", /octavo\.wasm: .*\/no\//));
  host.files.set("/page.wasm", Buffer.from("<!doctype html>"));
  for (const name of ["/none.wasm", "/page.wasm"]) {
    await assert.rejects(createPool({ wasm: host.url + name }),
      failsWith("io", new RegExp(`octavo\\.wasm: .*${host.url}${name}`)));
  }
  const none = await createPool({ workers: 1, worker: "/no/worker-node.js" });
  await assert.rejects(
    open(golden("small-int16.8vo"), { pool: none }).then((own) => own.read(whole(own), 0)),
    failsWith("internal", /\/no\/worker-node\.js/));
});

test("closing ends what waits, whether it was asked for or not, as closed", async () => {
  const { bytes } = await builtScan(6);
  const local = await createPool({ workers: 0 });
  for (const own of [pool, local]) {
    const url = serve(bytes);
    const scan = await open(url, { pool: own, parallelRequests: 1 });
    host.misbehave = () => new Promise(() => undefined);
    const low = { lo: [0, 0, 0], hi: [64, 64, 8] };
    const high = { lo: [64, 32, 72], hi: [128, 96, 80] };
    const reads = [low, high].map((box) =>
      assert.rejects(scan.read(box, 0), failsWith("closed", /closed/)));
    while (scan.statistics.pendingRequests < 2) await new Promise((go) => setTimeout(go, 5));
    scan.close();
    await Promise.all(reads);
  }
  local.close();
});

test("one signal for many reads is no reason for a warning", async () => {
  const told = [];
  const hear = (warning) => told.push(warning.name);
  process.on("warning", hear);
  const scan = await open(serve((await builtScan(7)).bytes), { pool, joinGapBytes: 0 });
  const { signal } = new AbortController();
  const planes = Array.from({ length: 30 }, (_, z) => ({ lo: [0, 0, z], hi: [128, 96, z + 1] }));
  await Promise.all(planes.map((box) => scan.read(box, 0, { signal })));
  await new Promise((go) => setTimeout(go, 20));
  process.off("warning", hear);
  assert.deepEqual(told, []);
  scan.close();
});

test("a shorter file in place of another one is another one", async () => {
  const { bytes } = await builtScan(8);
  const short = golden("small-int16.8vo");
  const end = { lo: [64, 32, 64], hi: [128, 96, 80] };
  const replaced = failsWith("replaced", /another file stands there now/);
  const hiding = (request, response) => {
    const [first, last] = /=(\d+)-(\d+)$/.exec(request.headers.range).slice(1).map(Number);
    const part = host.files.get("/scan.8vo").subarray(first, last + 1);
    response.writeHead(part.length > 0 ? 206 : 416, { "Content-Length": part.length });
    response.end(part);
    return true;
  };
  for (const size of [short.length, bytes.length / 2]) {
    const now = size === short.length ? short : bytes.subarray(0, size);
    let mine = bytes;
    const fetcher = {
      name: "mine", fetchBytes: async (offset, length) => mine.slice(offset, offset + length) };
    for (const way of ["told", "hidden", "fetcher"]) {
      const url = serve(bytes);
      if (way === "hidden") host.misbehave = hiding;
      const scan = await open(way === "fetcher" ? fetcher : url, { pool });
      host.files.set("/scan.8vo", Buffer.from(now));
      mine = now;
      await assert.rejects(scan.read(end, 0), replaced, `${way} ${size}`);
      if (size === short.length) {
        const again = await scan.reopen();
        assert.equal(again.byteLength, size);
        again.close();
      }
      mine = bytes;
    }
  }
  // One that never was whole is not.
  const half = serve(bytes.subarray(0, bytes.length / 2));
  await assert.rejects(open(half, { pool }), failsWith("truncated", /scan\.8vo/));
  host.misbehave = hiding;
  await assert.rejects(open(half, { pool }), OctavoError);
});

test("what the server answered stands in the error", async () => {
  serve(golden("small-int16.8vo"));
  await assert.rejects(open(`${host.url}/none.8vo`, { pool }), (error) => error.status === 404);
});

test("an address with a name or password is rejected without a request", async () => {
  host.log.length = 0;
  for (const user of ["name", "name:word", ":word"]) {
    const url = host.url.replace("//", `//${user}@`) + "/scan.8vo";
    for (const source of [url, new URL(url)]) {
      await assert.rejects(open(source, { pool }),
        failsWith("invalid_argument", /^scan\.8vo: browsers reject addresses with/));
    }
  }
  assert.equal(host.log.length, 0);
});

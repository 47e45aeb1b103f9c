// @octavo/reader in Chromium: the voxels of the program, from another origin that allows no more
// than it has to.
import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { gzipSync } from "node:zlib";
import { inChromium, newPage } from "./support/chromium.mjs";
import {
  dist, golden, goldenFolder, goldenNames, programDigests,
} from "./support/golden.mjs";
import { damagedFiles } from "./support/damage.mjs";
import { startServer } from "./support/server.mjs";

const blank = "<!doctype html><title>test</title>";

let site;
let files;
before(async () => {
  site = await startServer({ "/dist/": dist });
  site.files.set("/favicon.ico", Buffer.alloc(0));
  site.misbehave = (request, response, entry) => {
    if (entry.path !== "/") return false;
    response.writeHead(200, { "Content-Type": "text/html" }).end(blank);
    return true;
  };
  files = await startServer({ "/golden/": goldenFolder });
  // Neither Content-Range nor ETag can be read by the page.
  files.headers = { "Access-Control-Allow-Origin": "*" };
});
after(async () => {
  await site.close();
  await files.close();
});

test("every level of every golden file has the voxels of the program", async () => {
  const expected = await programDigests();
  const found = await inChromium(async (browser) => {
    const page = await newPage(browser, site.url);
    const digests = await page.evaluate(async ([names, folder]) => {
      const { open } = await import("/dist/reader.js");
      const all = {};
      for (const name of names) {
        const scan = await open(folder + name);
        all[name] = [];
        for (const { level, size } of scan.levels) {
          const voxels = await scan.read({ lo: [0, 0, 0], hi: size }, level);
          const digest = new Uint8Array(await crypto.subtle.digest("SHA-1", voxels));
          all[name].push(Array.from(digest, (byte) => byte.toString(16).padStart(2, "0")).join(""));
        }
        scan.close();
      }
      return all;
    }, [goldenNames(), `${files.url}/golden/`]);
    assert.deepEqual(page.errors, []);
    return digests;
  });
  assert.deepEqual(found, expected);
  assert.ok(files.log.every((entry) => entry.method === "GET"), "no leave is asked for");
});

test("200 damaged files: a sentence each, and the next file still opens", async () => {
  const sound = golden("small-int16.8vo");
  damagedFiles(goldenNames().map((name) => [name, golden(name)]), 200).forEach(({ bytes }, i) => {
    files.files.set(`/damaged/${i}.8vo`, Buffer.from(bytes));
  });
  files.files.set("/sound.8vo", Buffer.from(sound));
  const { messages, length } = await inChromium(async (browser) => {
    const page = await newPage(browser, site.url);
    return page.evaluate(async (url) => {
      const { open } = await import("/dist/reader.js");
      const messages = [];
      for (let i = 0; i < 200; ++i) {
        try {
          const scan = await open(`${url}/damaged/${i}.8vo`);
          for (const { level, size } of scan.levels) {
            await scan.read({ lo: [0, 0, 0], hi: size }, level);
          }
          scan.close();
        } catch (error) {
          messages.push([error.kind ?? "none", error.message]);
        }
      }
      const scan = await open(`${url}/sound.8vo`);
      const voxels = await scan.read({ lo: [0, 0, 0], hi: scan.size }, 0);
      return { messages, length: voxels.length };
    }, files.url);
  });
  assert.ok(messages.length > 150, `${messages.length} of 200 were found out`);
  for (const [kind, message] of messages) {
    assert.ok(!["none", "internal"].includes(kind), message);
    assert.match(message, /^\d+\.8vo: [^\n]{8,400}$/);
  }
  assert.ok(length > 0);
});

test("a page takes the package, its worker and its wasm from another origin", async () => {
  files.files.set("/scan.8vo", Buffer.from(golden("small-int16.8vo")));
  const scripts = await startServer({ "/dist/": dist });
  scripts.headers = { "Access-Control-Allow-Origin": "*" };
  try {
    const count = await inChromium(async (browser) => {
      const page = await newPage(browser, site.url);
      return page.evaluate(async ([from, url]) => {
        const { open } = await import(`${from}/dist/reader.js`);
        const scan = await open(url);
        return (await scan.read({ lo: [0, 0, 0], hi: scan.size }, 0)).length;
      }, [scripts.url, `${files.url}/scan.8vo`]);
    });
    assert.ok(count > 0);
    assert.equal(scripts.requestsOf("/dist/worker.js").length > 0, true);
  } finally {
    await scripts.close();
  }
});

test("what is no signal, place or address is named in a page as it is in Node.js", async () => {
  files.files.set("/scan.8vo", Buffer.from(golden("small-int16.8vo")));
  const found = await inChromium(async (browser) => {
    const page = await newPage(browser, site.url);
    return page.evaluate(async (url) => {
      const { createPool, open } = await import("/dist/reader.js");
      const scan = await open(url);
      const all = { lo: [0, 0, 0], hi: scan.size };
      const failures = [];
      for (const call of [
        () => open(url, { signal: 3 }),
        () => scan.read(all, 0, { signal: 3 }),
        () => scan.plan(all, 0, { signal: {} }),
        () => createPool({ wasm: 42 }),
        () => createPool({ worker: {} }),
        () => createPool({ wasm: "http://[" }),
      ]) {
        failures.push(await call().then(() => "", ({ kind, message }) => `${kind}: ${message}`));
      }
      // Signals of another frame are signals as well.
      const frame = document.body.appendChild(document.createElement("iframe"));
      const { signal } = new frame.contentWindow.AbortController();
      return { failures, count: (await scan.read(all, 0, { signal })).length };
    }, `${files.url}/scan.8vo`);
  });
  assert.deepEqual(found.failures, [
    "invalid_argument: signal is 3, no AbortSignal",
    "invalid_argument: signal is 3, no AbortSignal",
    "invalid_argument: signal is [object Object], no AbortSignal",
    "invalid_argument: wasm is 42, no address and no path",
    "invalid_argument: worker is [object Object], no address and no path",
    "invalid_argument: http://[: no address",
  ]);
  assert.ok(found.count > 0);
});

test("a server that compresses ranges is told from one that allows no other pages", async () => {
  const bytes = golden("small-int16.8vo");
  const compressing = (isWhole) => (request, response, entry) => {
    if (entry.path !== "/scan.8vo") return false;
    const ends = /(\d+)-(\d+)/.exec(entry.range)?.slice(1).map(Number);
    const [first, last] = ends ?? [0, bytes.length];
    const part = gzipSync(bytes.subarray(first, last + 1));
    response.writeHead(entry.range ? 206 : 200, {
      ...(entry.range || isWhole ? { "Content-Encoding": "gzip" } : {}),
      ...(entry.range ? { "Content-Range": `bytes ${first}-${last}/${bytes.length}` } : {}),
    });
    response.end(request.method === "HEAD" ? undefined : part);
    return true;
  };
  const why = async (url) => inChromium(async (browser) => {
    const page = await newPage(browser, site.url);
    return page.evaluate(async (from) => {
      const { open } = await import("/dist/reader.js");
      return open(from).then(() => "", ({ kind, message }) => `${kind}: ${message}`);
    }, url);
  });
  const before = site.misbehave;
  try {
    for (const isWhole of [true, false]) {
      site.misbehave = (...call) => before(...call) || compressing(isWhole)(...call);
      assert.match(await why(`${site.url}/scan.8vo`), isWhole
        ? /^io: scan\.8vo: the server compresses it \(Content-Encoding: gzip\)/
        : /^io: scan\.8vo: .*compressed \(Content-Encoding\)/);
    }
    files.misbehave = compressing(true);
    const ofOther = await why(`${files.url}/scan.8vo`);
    assert.match(ofOther, /compressed \(Content-Encoding\)/);
    assert.doesNotMatch(ofOther, /CORS/);
    files.misbehave = null;
    files.files.set("/scan.8vo", Buffer.from(bytes));
    files.headers = {};
    assert.match(await why(`${files.url}/scan.8vo`), /does not let pages of other sites read it/);
  } finally {
    site.misbehave = before;
    files.misbehave = null;
    files.headers = { "Access-Control-Allow-Origin": "*" };
  }
});

test("a dropped file opens without a request", async () => {
  const found = await inChromium(async (browser) => {
    const page = await newPage(browser, site.url);
    await page.setContent("<input type=file>");
    await page.setInputFiles("input", join(goldenFolder, "labels-uint8.8vo"));
    const asked = files.log.length;
    const said = await page.evaluate(async () => {
      const { open } = await import("/dist/reader.js");
      const scan = await open(document.querySelector("input").files[0]);
      const voxels = await scan.read({ lo: [0, 0, 0], hi: scan.size }, 0);
      return { name: scan.name, kind: scan.kind, count: voxels.length };
    });
    assert.equal(files.log.length, asked);
    return said;
  });
  assert.equal(found.name, "labels-uint8.8vo");
  assert.equal(found.kind, "labels");
});

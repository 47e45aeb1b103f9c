// A published folder on the servers of other people: nginx and caddy as HOSTING.md configures them,
// and the one of Python; the page from the same origin, and from another one that is allowed no more
// than reading.
//
// usage: OCTAVO=build/octavo node tests/web/servers_test.mjs FOLDER, which tests/web/setup has filled
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { inChromium, newPage } from "./support/chromium.mjs";
import { builtScan, root, run } from "./support/golden.mjs";
import { findServersIn, hasServer, realServers, startRealServer } from "./support/real_servers.mjs";
import { startServer } from "./support/server.mjs";
import { settled, text } from "./support/viewer_page.mjs";

if (process.argv[2]) findServersIn(process.argv[2]);
const viewport = { width: 700, height: 480 };
let folder;
let page;
let expected;
before(async () => {
  folder = mkdtempSync(join(tmpdir(), "octavo-servers-"));
  // Larger than what opening fetches.
  const scan = await builtScan(5);
  expected = scan.voxels;
  writeFileSync(join(folder, "scan.8vo"), scan.bytes);
  process.env.OCTAVO_WEB = join(root, "web/viewer/dist");
  run("publish", join(folder, "scan.8vo"), "-o", join(folder, "scans"));
  page = await startServer({ "/": join(root, "web/viewer/dist") });
  page.files.set("/favicon.ico", Buffer.alloc(0));
  page.files.set("/files.json", Buffer.from("[]"));
});
after(async () => {
  await page.close();
  rmSync(folder, { recursive: true, force: true });
});

/** Opens a page and waits until all that it shows is the scan itself. */
async function whole(shown) {
  await settled(shown);
  await shown.waitForFunction(
    () => document.getElementById("fidelity").textContent === "full resolution");
  const [x, y, z] = [41, 50, 60];
  await shown.evaluate((at) => octavo.store.set({ at }), [x, y, z]);
  await settled(shown);
  const found = await shown.evaluate((at) => octavo.session.valueAt(at), [x, y, z]);
  assert.deepEqual(found, { stored: expected[(z * 96 + y) * 128 + x], level: 0 });
  return shown.evaluate(() => octavo.session.volume.traffic());
}

for (const name of realServers) {
  const skip = hasServer(name) ? false : `no ${name}; tests/web/setup fetches it`;
  const answersRanges = name !== "python3";

  test(`${name}: the page and the scan from one origin`, { skip }, async () => {
    const server = await startRealServer(name, folder);
    await inChromium(async (browser) => {
      const shown = await newPage(browser, `${server.url}/index.html?url=scan.8vo&layout=z`,
        { viewport });
      const { requests } = await whole(shown);
      const isNoted = /range/i.test(await text(shown, "message"));
      assert.equal(isNoted, !answersRanges);
      assert.ok(requests > 2 || !answersRanges, `${requests}`);
      assert.deepEqual(shown.errors.filter((line) => !line.includes("404")), []);
    });
    await server.close();
  });

  test(`${name}: the scan from another origin`, { skip }, async () => {
    const server = await startRealServer(name, folder);
    await inChromium(async (browser) => {
      const url = encodeURIComponent(`${server.url}/scan.8vo`);
      const shown = await newPage(browser, `${page.url}/index.html?url=${url}&layout=z`,
        { viewport });
      if (answersRanges) {
        await whole(shown);
        assert.equal(await shown.locator("#message").isVisible(), false);
      } else {
        // It allows no other origin.
        await shown.waitForFunction(() => !document.getElementById("message").hidden);
        assert.match(await text(shown, "message"), /scan\.8vo: .*(origin|server)/);
      }
    });
    const methods = new Set(server.requests().map(({ method }) => method));
    if (answersRanges) assert.deepEqual([...methods], ["GET"]);
    await server.close();
  });
}

test("a scan that is published anew is not mixed with the one that is open", {
  skip: hasServer("nginx") ? false : "no nginx; tests/web/setup fetches it",
}, async () => {
  const server = await startRealServer("nginx", folder);
  const file = join(folder, "scans/scan.8vo");
  const first = readFileSync(file);
  await inChromium(async (browser) => {
    const shown = await newPage(browser, `${server.url}/index.html?url=scan.8vo&layout=z`,
      { viewport });
    await shown.waitForFunction(() => globalThis.octavo?.session?.hasPreview);
    const other = await builtScan(6);
    // As HOSTING.md says: written beside it, and renamed.
    writeFileSync(`${file}.new`, other.bytes);
    renameSync(`${file}.new`, file);
    await shown.evaluate(() => octavo.store.set({ at: [10, 10, 70], layout: "y" }));
    const open = shown.locator("#message button", { hasText: "Open the new file" });
    await open.waitFor();
    await open.click();
    await settled(shown);
    await shown.evaluate(() => octavo.store.set({ at: [41, 50, 60] }));
    await settled(shown);
    const found = await shown.evaluate(() => octavo.session.valueAt([41, 50, 60]));
    assert.deepEqual(found, { stored: other.voxels[(60 * 96 + 50) * 128 + 41], level: 0 });
  });
  writeFileSync(file, first);
  await server.close();
});

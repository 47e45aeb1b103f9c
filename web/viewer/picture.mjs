// A picture of the page: node picture.mjs SITE OUT.png [QUERY] [WIDTHxHEIGHT] [dark]
//
// SITE is what `octavo publish` writes; Chromium shows it, on a server of its own.
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { inChromium, newPage } from "../../tests/web/support/chromium.mjs";
import { startServer } from "../../tests/web/support/server.mjs";

const [site, out, query = "", size = "1280x800", scheme = "light"] = process.argv.slice(2);
if (!out) throw new Error(`usage: ${fileURLToPath(import.meta.url)} SITE OUT.png ...`);
const [width, height] = size.split("x").map(Number);
const host = await startServer({ "/": join(process.cwd(), site) });
await inChromium(async (browser) => {
  const page = await newPage(browser, `${host.url}/index.html${query}`, {
    viewport: { width, height }, colorScheme: scheme, hasTouch: width < 600,
  });
  await page.waitForFunction(() => {
    const { session, rays } = globalThis.octavo ?? {};
    return session?.hasPreview && !session.cells.isBusy && session.cells.missing().length === 0 &&
      (!rays.isShown || rays.isSettled);
  }, null, { timeout: 240_000 });
  await page.waitForTimeout(600);
  await page.screenshot({ path: out });
});
await host.close();

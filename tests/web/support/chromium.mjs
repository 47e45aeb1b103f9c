// Debian's Chromium, driven by playwright-core.
import { createRequire } from "node:module";
import { join } from "node:path";
import { root } from "./golden.mjs";

/** Machines with much to do take their time: a test fails where nothing comes at all. */
export const patienceMs = 600_000;

/** Calls `use` with a browser that is gone afterwards. */
export async function inChromium(use) {
  const { chromium } = createRequire(join(root, "web/package.json"))("playwright-core");
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    timeout: patienceMs,
    args: [
      "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
      "--no-first-run", "--disable-background-networking", "--disable-component-update",
      "--disable-sync",
    ],
  });
  try {
    return await use(browser);
  } finally {
    await browser.close();
  }
}

/** A page whose errors end the test that looks at them. */
export async function newPage(browser, url, options = {}) {
  const page = await browser.newPage(options);
  page.setDefaultTimeout(patienceMs);
  page.errors = [];
  page.on("pageerror", (error) => page.errors.push(String(error)));
  page.on("console", (message) => {
    if (message.type() === "error") page.errors.push(message.text());
  });
  await page.goto(url);
  return page;
}

// The page under hands: fingers, keys, switches, sliders, points of a curve, a file that is dropped.
//
// usage: OCTAVO=build/octavo node tests/web/controls_test.mjs
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { inChromium, patienceMs } from "./support/chromium.mjs";
import { inFolder, run } from "./support/golden.mjs";
import { calm, settled, startPage, text, withPage } from "./support/viewer_page.mjs";

let host;
let files;
before(async () => {
  ({ host, files } = await startPage());
});
after(() => host.close());

const state = (shown, ...keys) =>
  shown.evaluate((names) => names.map((name) => octavo.store.now[name]), keys);

/** A place of a panel, in parts of its sides. */
async function place(shown, id, x, y) {
  const box = await shown.locator(`#${id}`).boundingBox();
  return [box.x + box.width * x, box.y + box.height * y];
}

async function drag(shown, id, from, to, button = "left") {
  await shown.mouse.move(...(await place(shown, id, ...from)));
  await shown.mouse.down({ button });
  await shown.mouse.move(...(await place(shown, id, ...to)), { steps: 4 });
  await shown.mouse.up({ button });
}

/** Lets a file fall on the page, and others of no bytes with it. */
const drop = (shown, bytes, ...names) => shown.evaluate(([all, ...called]) => {
  const held = new DataTransfer();
  called.forEach((name, i) => held.items.add(new File(i ? [] : [Uint8Array.from(all)], name)));
  for (const kind of ["dragover", "drop"]) {
    document.body.dispatchEvent(new DragEvent(kind, {
      dataTransfer: held, bubbles: true, cancelable: true }));
  }
}, [[...bytes], ...names]);

test("every control has a name, and the panels say what they show", async () => {
  await withPage("?url=scan.8vo&labels=labels.8vo", async (shown) => {
    await shown.waitForFunction(() => octavo?.overlay?.hasPreview);
    await settled(shown);
    const nameless = await shown.evaluate(() => [...document.querySelectorAll(
      "button, input, select, [role=application], [role=toolbar], [role=radiogroup], canvas[role]")]
      .filter((one) => !one.getAttribute("aria-label") && !one.title && !one.textContent.trim() &&
        !one.closest("label") && !one.hidden)
      .map((one) => one.outerHTML));
    assert.deepEqual(nameless, []);
    const label = (id) => shown.locator(`#${id}`).getAttribute("aria-label");
    assert.match(await label("panel-z"), /^across z slice, z 45 \/ 89, 1\/\d of full resolution$/);
    assert.match(await label("panel-3d"), /^3-D view, 1\/\d of full resolution/);
    await shown.waitForFunction(() => document.getElementById("spoken").textContent !== "");
    assert.match(await text(shown, "spoken"), /^voxel 75, 65, 45 · .* mm · /);
  }, { viewport: { width: 900, height: 640 } });
});

test("sides change places, a window is dragged, an angle is measured", async () => {
  await withPage("?url=scan.8vo&layout=z", async (shown) => {
    await settled(shown);
    const sides = () => shown.evaluate(() => {
      const { left, right } = octavo.slices[2].orientation;
      return [left, right];
    });
    assert.deepEqual(await sides(), ["R", "L"]);
    await shown.locator("button[title^='Neurological']").click();
    assert.deepEqual(await sides(), ["L", "R"]);
    const [before] = await state(shown, "window");
    await drag(shown, "panel-z", [0.4, 0.5], [0.6, 0.4], "right");
    const [after] = await state(shown, "window");
    assert.ok(after.width > before.width && after.center !== before.center);
    await shown.keyboard.press("a");
    for (const at of [[0.4, 0.3], [0.4, 0.6], [0.6, 0.6]]) {
      await shown.mouse.click(...(await place(shown, "panel-z", ...at)));
    }
    const isRight = async () =>
      assert.match(await text(shown, "measurements"), /angle z \d+: (89\.|90\.)\d°/);
    await isRight();
    await shown.keyboard.press("Delete");
    assert.deepEqual(await state(shown, "measurements"), [[]]);
    // The first leg is dragged, the last point clicked; or the other way round.
    await drag(shown, "panel-z", [0.4, 0.3], [0.4, 0.6]);
    await shown.mouse.click(...(await place(shown, "panel-z", 0.6, 0.6)));
    await isRight();
    await shown.keyboard.press("Delete");
    await shown.mouse.click(...(await place(shown, "panel-z", 0.4, 0.3)));
    await drag(shown, "panel-z", [0.5, 0.5], [0.4, 0.6]);
    await shown.mouse.click(...(await place(shown, "panel-z", 0.6, 0.6)));
    await isRight();
    await shown.keyboard.press("Delete");
  });
});

test("curve, clip box, isovalue and modes change the 3-D view", async () => {
  await withPage("?url=scan.8vo&layout=3d&mode=volume", async (shown) => {
    await settled(shown);
    const [curve] = await state(shown, "transfer");
    const point = await shown.evaluate(() => {
      const box = document.getElementById("transfer").getBoundingClientRect();
      const [x, y] = octavo.transfer.place(
        octavo.store.now.transfer[1].value, octavo.store.now.transfer[1].opacity);
      return [box.x + x, box.y + y];
    });
    await shown.mouse.move(...point);
    await shown.mouse.down();
    await shown.mouse.move(point[0] + 6, point[1] - 25, { steps: 3 });
    await shown.mouse.up();
    const [moved, name] = await state(shown, "transfer", "transferName");
    assert.ok(moved[1].opacity > curve[1].opacity && moved[1].value > curve[1].value);
    assert.equal(name, "own");
    await shown.locator("summary", { hasText: "Clip box" }).click();
    await shown.locator("input[aria-label='Clip x, to']").fill("60");
    assert.equal((await state(shown, "clip"))[0].hi[0], 60);
    await shown.locator("#modes button", { hasText: "Surface" }).click();
    await shown.locator("#iso").fill("650");
    assert.deepEqual(await state(shown, "mode", "iso"), ["iso", 650]);
    await settled(shown);
    const [camera] = await state(shown, "camera");
    await drag(shown, "panel-3d", [0.5, 0.5], [0.7, 0.5]);
    assert.notEqual((await state(shown, "camera"))[0].azimuth, camera.azimuth);
    await shown.locator("#panel-3d").focus();
    await shown.keyboard.press("+");
    assert.ok((await state(shown, "camera"))[0].zoom > camera.zoom);
    // A link brings curve and clip box along.
    await shown.locator("#modes button", { hasText: "Volume" }).click();
    const link = await shown.evaluate(() => octavo.permalink());
    assert.match(link, /&clip=0:60,0:130,0:90&curve=[^&]+$/);
    await shown.goto(link);
    await settled(shown);
    const [clip, again] = await state(shown, "clip", "transfer");
    assert.deepEqual(clip, { lo: [0, 0, 0], hi: [60, 130, 90] });
    assert.deepEqual(again.map((p) => p.color), moved.map((p) => p.color));
    again.forEach((p, i) => assert.ok(Math.abs(p.opacity - moved[i].opacity) < 1e-5));
    assert.deepEqual(await state(shown, "transferName", "mode"), ["own", "volume"]);
  }, { viewport: { width: 760 + 20, height: 560 } });
});

test("dark and light change places and last", async () => {
  await withPage("?url=scan.8vo&layout=z", async (shown) => {
    await settled(shown);
    const page = () => shown.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const before = await page();
    await shown.keyboard.press("t");
    const other = await page();
    assert.notEqual(other, before);
    await shown.reload();
    assert.equal(await page(), other);
  });
});

test("a file that is dropped is shown without a request", async () => {
  await withPage("", async (shown) => {
    await shown.locator("#welcome").waitFor();
    host.log.length = 0;
    await drop(shown, files.scan, "dropped.8vo");
    await settled(shown);
    assert.equal(await text(shown, "title"), "dropped.8vo");
    assert.deepEqual(host.requestsOf("/scan.8vo"), []);
  });
});

test("of files that are dropped at once the first is opened, and the page says so", async () => {
  await withPage("", async (shown) => {
    await drop(shown, files.scan, "dropped.8vo", "second.8vo", "third.8vo");
    await settled(shown);
    assert.equal(await text(shown, "title"), "dropped.8vo");
    assert.match(await text(shown, "message"), /^3 files at once: dropped\.8vo alone is opened/);
    await drop(shown, files.labels, "labels.8vo");
    await shown.waitForFunction(() => octavo.overlay?.facts.name === "labels.8vo");
    assert.equal(await text(shown, "message"), "");
  });
});

test("the address names what is open, and nothing that a file took the place of", async () => {
  const search = (shown) => shown.evaluate(() => location.search);
  await withPage("?url=scan.8vo&labels=labels.8vo&layout=z", async (shown) => {
    await shown.waitForFunction(() => octavo?.overlay?.hasPreview);
    assert.equal(await search(shown), "?url=scan.8vo&labels=labels.8vo&layout=z");
    await drop(shown, files.labels, "own.8vo");
    await shown.waitForFunction(() => octavo.overlay.facts.name === "own.8vo");
    assert.equal(await search(shown), "?url=scan.8vo&layout=z");
    await drop(shown, files.scan, "dropped.8vo");
    await shown.waitForFunction(() => octavo.session.facts.name === "dropped.8vo");
    await settled(shown);
    assert.equal(await search(shown), "");
    await shown.evaluate(() => octavo.open(new URL("scan.8vo", location.href).href));
    assert.equal(await search(shown), "?url=scan.8vo");
    await settled(shown);
  });
});

test("parts of other names and the end of an address stay when another scan is opened", async () => {
  await withPage("?token=a%20b&url=scan.8vo&layout=z#h", async (shown) => {
    await settled(shown);
    const query = await shown.evaluate(() => octavo.permalink().split("?")[1]);
    assert.match(query, /^url=scan\.8vo&at=.*&layout=z&.*&token=a%20b#h$/);
    await drop(shown, files.scan, "dropped.8vo");
    await shown.waitForFunction(() => octavo.session.facts.name === "dropped.8vo");
    assert.match(await shown.evaluate(() => location.href), /\/index\.html\?token=a%20b#h$/);
    await settled(shown);
  });
});

test("a file that can never open is named, and offers no other try", async () => {
  await withPage("", async (shown) => {
    await drop(shown, Buffer.from("no scan ".repeat(100)), "notes.txt");
    await shown.locator("#message").waitFor();
    assert.match(await text(shown, "message"), /^notes\.txt/);
    assert.deepEqual(await shown.locator("#message button").allTextContents(), ["✕"]);
  });
});

test("letters of all languages stay in the names of pictures", async () => {
  await withPage("", async (shown) => {
    await drop(shown, files.scan, "Schädel von Jörg #1 100%? 頭.8vo");
    await settled(shown);
    const [saved] = await Promise.all([
      shown.waitForEvent("download"), shown.locator("button[title^='Save']").click()]);
    assert.equal(saved.suggestedFilename(), "Schädel_von_Jörg_1_100_頭.8vo.png");
  });
});

test("fields show the window that is, whatever was typed", async () => {
  await withPage("?url=scan.8vo&layout=z&window=100,600", async (shown) => {
    await settled(shown);
    const width = shown.locator("#width");
    for (const typed of ["0", "-5", ""]) {
      await width.fill(typed);
      await width.press("Enter");
      assert.equal(await width.inputValue(), "600", `after "${typed}"`);
    }
    await shown.locator("#center").fill("");
    await shown.locator("#center").press("Enter");
    await width.fill("50");
    await width.press("Enter");
    assert.deepEqual(await state(shown, "window"), [{ center: 100, width: 50 }]);
  }, { viewport: { width: 900, height: 560 } });
});

/** A file whose table names more labels than a list draws at once. */
function manyLabels(count) {
  return inFolder((folder) => {
    const at = (name) => join(folder, name);
    writeFileSync(at("l.raw"), new Uint16Array(512).fill(1));
    const line = (_, i) => `${i + 1} ${i + 1 === 4100 ? "Tail of all" : `part ${i + 1}`}\n`;
    writeFileSync(at("names.txt"), Array.from({ length: count }, line).join(""));
    run("build", at("l.raw"), "--raw", "8,8,8,uint16", "--spacing", "1", "--labels",
      "--label-names", at("names.txt"), "-o", at("l.8vo"));
    return readFileSync(at("l.8vo"));
  });
}

test("each of many labels is found by name or number, scrolled to, shown alone", async () => {
  const most = 5280;
  host.files.set("/many.8vo", await manyLabels(most));
  await withPage("?url=many.8vo&layout=z", async (shown) => {
    await settled(shown);
    const rows = shown.locator("#labels li");
    const hidden = async () => new Set(
      await shown.evaluate(() => [...octavo.store.now.hiddenLabels]));
    assert.ok(await rows.count() < most);
    await shown.locator(`[data-label="1"]`).uncheck();
    while (await rows.count() < most) {
      const before = await rows.count();
      await rows.last().scrollIntoViewIfNeeded();
      await shown.waitForFunction(
        (n) => document.querySelectorAll("#labels li").length > n, before);
    }
    await shown.locator(`[data-label="${most}"]`).uncheck();
    assert.deepEqual(await hidden(), new Set([1, most]));
    const find = shown.locator("#labels-find");
    await find.fill("528");
    assert.deepEqual(
      await rows.locator("input").evaluateAll((all) => all.map((one) => one.dataset.label)),
      ["528", "1528", "2528", "3528", "4528", "5280"]);
    assert.equal(await shown.locator(`[data-label="${most}"]`).isChecked(), false);
    await find.fill("tail OF");
    assert.equal(await rows.count(), 1);
    await rows.locator("button").click();
    const alone = await hidden();
    assert.ok(alone.size === most - 1 && !alone.has(4100));
    await rows.locator("button").click();
    assert.equal((await hidden()).size, 0);
    await find.fill("part 12");
    const found = await rows.count();
    await shown.locator("#labels-none").click();
    assert.equal((await hidden()).size, found);
    assert.ok((await hidden()).has(1234));
    await find.fill("");
    await shown.locator("#labels-all").click();
    assert.equal((await hidden()).size, 0);
    await find.fill("no such label");
    assert.equal(await rows.count(), 0);
  }, { viewport: { width: 900, height: 700 } });
});

test("fingers move the cursor, two of them zoom; a phone shows all tools", async () => {
  calm();
  await inChromium(async (browser) => {
    const context = await browser.newContext({
      viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true });
    context.setDefaultTimeout(patienceMs);
    const shown = await context.newPage();
    await shown.goto(`${host.url}/index.html?url=scan.8vo&layout=z&mode=volume`);
    await settled(shown);
    await shown.touchscreen.tap(...(await place(shown, "panel-z", 0.3, 0.5)));
    const [tapped] = await state(shown, "at");
    assert.ok(tapped[0] < 60, `${tapped}`);
    const client = await context.newCDPSession(shown);
    const touch = async (type, ...points) => client.send("Input.dispatchTouchEvent", {
      type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    const at = (x) => place(shown, "panel-z", x, 0.5);
    await touch("touchStart", await at(0.4), await at(0.6));
    for (const more of [0.05, 0.1, 0.15, 0.2]) {
      await touch("touchMove", await at(0.4 - more), await at(0.6 + more));
    }
    await touch("touchEnd");
    const [slices] = await state(shown, "slices");
    assert.ok(slices[2].zoom > 1.5, JSON.stringify(slices[2]));
    const isWide = await shown.evaluate(
      () => document.documentElement.scrollWidth > document.documentElement.clientWidth);
    assert.equal(isWide, false);
    // Settings are a button away.
    await shown.locator("button[title='Show or hide the settings']").click();
    await shown.waitForFunction(() => {
      const curve = document.getElementById("transfer");
      const { data } = curve.getContext("2d").getImageData(0, 0, curve.width, curve.height);
      return curve.width > 300 && data.some((value) => value > 0);
    });
    await shown.locator("#preset").selectOption("bone");
    assert.deepEqual(await state(shown, "window"), [{ center: 400, width: 1800 }]);
  });
});

// The page of the viewer in Chromium: what it shows, measures and passes on, and what it does when
// servers and files are not as they promised.
//
// usage: OCTAVO=build/octavo node tests/web/viewer_test.mjs
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { builtRaw, builtScan } from "./support/golden.mjs";
import { pngPixels } from "./support/png.mjs";
import { beginRange } from "./support/server.mjs";
import {
  HOSTILE, calm, panelPng, settled, showRaysAlone, startPage, text, withPage,
} from "./support/viewer_page.mjs";

let host;
let files;
before(async () => {
  ({ host, files } = await startPage());
});
after(() => host.close());

test("labels lie over the scan, with names as text and never as markup", async () => {
  await withPage("?url=scan.8vo&labels=labels.8vo&at=75,65,40", async (shown) => {
    await shown.waitForFunction(
      () => document.querySelectorAll("#labels li").length === 2);
    await settled(shown);
    const names = await shown.locator("#labels li span:nth-of-type(2)").allTextContents();
    assert.ok(names.some((name) => name === HOSTILE), JSON.stringify(names));
    assert.equal(await shown.locator("#labels img").count(), 0);
    assert.doesNotMatch(await shown.title(), /taken/);
    await shown.waitForFunction(
      () => document.getElementById("readout").textContent.includes("inside"));
    const colored = async () => {
      const seen = pngPixels(await shown.locator("#panel-z").screenshot());
      return seen.isColored;
    };
    await shown.evaluate(() => {
      octavo.store.set({ hasAnnotations: false });
      for (const slider of document.querySelectorAll(".panel input")) slider.hidden = true;
    });
    await shown.waitForTimeout(300);
    assert.equal(await colored(), true);
    await shown.locator("#labels-none").click();
    await shown.waitForTimeout(500);
    assert.equal(await colored(), false);
    const link = await shown.evaluate(() => octavo.permalink());
    assert.match(link, /&labels=labels\.8vo.*&hide=1-2$/);
    await shown.goto(link);
    await shown.waitForFunction(() => octavo?.overlay?.hasPreview);
    assert.deepEqual(await shown.evaluate(() => [...octavo.store.now.hiddenLabels]), [1, 2]);
    // A link cannot name labels of this machine, and must not name those that they replaced.
    const title = await shown.evaluate(async () => {
      const bytes = await (await fetch("labels.8vo")).arrayBuffer();
      await octavo.open(new File([bytes], "own.8vo"));
      return octavo.overlay.facts.name;
    });
    assert.equal(title, "own.8vo");
    assert.doesNotMatch(await shown.evaluate(() => octavo.permalink()), /labels/);
  }, { viewport: { width: 900, height: 560 } });
});

test("a link shows the scan that it names, or says why not", async () => {
  const shows = (shown, words) => shown.waitForFunction(
    (part) => document.getElementById("message").textContent.includes(part), words);
  host.files.set("/grey.8vo", files.scan);
  await withPage("?url=scan.8vo&labels=grey.8vo", async (shown) => {
    await shows(shown, "grey.8vo: holds no labels");
    await settled(shown);
    assert.equal(await text(shown, "title"), "scan.8vo");
    assert.doesNotMatch(await shown.evaluate(() => octavo.permalink()), /labels/);
  });
  await withPage("?url=labels.8vo&labels=grey.8vo", async (shown) => {
    await shows(shown, "grey.8vo: holds no labels");
    assert.equal(await text(shown, "title"), "labels.8vo");
  });
  const listed = JSON.stringify([{ title: "scan", url: "scan.8vo" }]);
  host.files.set("/files.json", Buffer.from(listed));
  try {
    await withPage("?url=javascript:alert(1)", async (shown) => {
      await shows(shown, "url=javascript:alert(1) was rejected");
      assert.equal(await shown.evaluate(() => octavo.session ?? null), null);
      assert.equal(await shown.locator("#listed li").count(), 1);
    });
  } finally {
    host.files.set("/files.json", Buffer.from("[]"));
  }
});

test("parts of a link that are not understood are named, numbers may have a plus", async () => {
  const query = "?url=scan.8vo&layout=q&curve=5:0:fff&side=left&at=1,2&hide=&other=1" +
    "&iso=+6e+2&clip=0:99999,-9:120,200:300&opacity=%2B5e-1";
  await withPage(query, async (shown) => {
    await settled(shown);
    await shown.locator("#message").waitFor();
    assert.match(await text(shown, "message"),
      /^not understood in this link: at=1,2; layout=q; curve=5:0:fff; side=left✕$/);
    const { iso, clip, overlayOpacity } = await shown.evaluate(() => octavo.store.now);
    assert.deepEqual({ iso, clip, overlayOpacity },
      { iso: 600, clip: { lo: [0, 0, 89], hi: [150, 120, 90] }, overlayOpacity: 0.5 });
  });
  // Why a file does not open is not written over.
  await withPage("?url=none.8vo&layout=q", async (shown) => {
    await shown.locator("#message button", { hasText: "Try again" }).waitFor();
    await shown.waitForFunction(
      () => document.getElementById("message").textContent.includes("layout=q"));
    assert.match(await text(shown, "message"), /none\.8vo/);
  }, { mayComplain: true });
});

test("keys, tools and links: what is seen can be passed on", async () => {
  await withPage("?url=scan.8vo&layout=z&at=75,65,40", async (shown) => {
    await settled(shown);
    await shown.locator("#panel-z").focus();
    await shown.keyboard.press("ArrowRight");
    await shown.keyboard.press("PageUp");
    await shown.keyboard.press("3");
    assert.deepEqual(await shown.evaluate(() => [octavo.store.now.at, octavo.store.now.window]),
      [[76, 65, 41], { center: 400, width: 1800 }]);
    await shown.keyboard.press("d");
    const box = await shown.locator("#panel-z").boundingBox();
    const drag = async (fx, fy, tx, ty) => {
      await shown.mouse.move(box.x + box.width * fx, box.y + box.height * fy);
      await shown.mouse.down();
      await shown.mouse.move(box.x + box.width * tx, box.y + box.height * ty, { steps: 3 });
      await shown.mouse.up();
    };
    await drag(0.4, 0.5, 0.6, 0.5);
    const line = await text(shown, "measurements");
    const mm = Number(/([\d.]+) mm/.exec(line)[1]);
    const pixelMm = await shown.evaluate(() => octavo.slices[2].look.pixelMm);
    assert.ok(Math.abs(mm - box.width * 0.2 * pixelMm) < pixelMm * 2, line);
    await shown.keyboard.press("e");
    await drag(0.45, 0.45, 0.55, 0.55);
    await shown.waitForFunction(
      () => /mean .* samples/.test(document.getElementById("measurements").textContent));
    const link = await shown.evaluate(() => octavo.permalink());
    assert.match(link, /\?url=scan\.8vo&at=76,65,41&window=400,1800&layout=z/);
    await shown.goto(link);
    await settled(shown);
    assert.deepEqual(await shown.evaluate(() => octavo.store.now.at), [76, 65, 41]);
    const [saved] = await Promise.all([
      shown.waitForEvent("download"), shown.locator("button[title^='Save']").click()]);
    assert.equal(saved.suggestedFilename(), "scan.8vo.png");
  });
});

test("a surface in 3-D covers the pixels that octavo render covers", async () => {
  const side = files.rays.width;
  await withPage("?url=scan.8vo&layout=3d&mode=iso&iso=600&camera=40,25,1", async (shown) => {
    await showRaysAlone(shown, side);
    const seen = pngPixels(await panelPng(shown, "panel-3d"));
    assert.deepEqual([seen.width, seen.height], [side, side]);
    let [both, any] = [0, 0];
    for (let i = 0; i < side * side; ++i) {
      const [a, b] = [files.rays.grey[i] > 24, seen.grey[i] > 32];
      both += a && b ? 1 : 0;
      any += a || b ? 1 : 0;
    }
    assert.ok(any > side * side * 0.2 && both / any > 0.97, `${both} of ${any}`);
  });
});

test("a lost graphics context is said to be lost until it is back with its picture", async () => {
  await withPage("?url=scan.8vo", async (shown) => {
    await settled(shown);
    const said = [];
    shown.on("console", (message) => said.push(message.text()));
    await shown.evaluate(() => octavo.store.set({ hasAnnotations: false }));
    const picture = async () => {
      await shown.waitForTimeout(300);
      await settled(shown);
      return pngPixels(await shown.locator("#panel-z").screenshot());
    };
    const before = await picture();
    const lose = () => shown.evaluate(() => {
      globalThis.card = document.getElementById("stage").getContext("webgl2")
        .getExtension("WEBGL_lose_context");
      card.loseContext();
    });
    const giveBack = async () => {
      const frames = await shown.evaluate(() => {
        card.restoreContext();
        return octavo.stage.frames;
      });
      await shown.waitForFunction((n) => octavo.stage.frames > n, frames);
    };
    await lose();
    await shown.locator("#message").waitFor();
    assert.match(await text(shown, "message"), /^The graphics card was lost/);
    await giveBack();
    await shown.locator("#message").waitFor({ state: "hidden" });
    assert.deepEqual((await picture()).grey, before.grey);
    assert.ok(before.grey.some((v) => v > 100));
    // What was said meanwhile stays.
    await lose();
    await shown.locator("#message").waitFor();
    await shown.evaluate(() => octavo.open("http://127.0.0.1:9/none.8vo"));
    await giveBack();
    assert.match(await text(shown, "message"), /none\.8vo/);
    assert.deepEqual(said.filter((line) => /does not belong|INVALID_OPERATION/.test(line)), []);
  }, { mayComplain: true });
});

test("a volume longer than a texture is shown, near and far", async () => {
  const [nx, side] = [300_000, 4];
  const voxels = Uint8Array.from({ length: nx * side * side },
    (_, i) => 100 + Math.floor((i % nx) / 2000));
  host.files.set("/long.8vo", await builtRaw(voxels, [nx, side, side]));
  await withPage("?url=long.8vo&layout=z&at=150000,2,2&window=128,256", async (shown) => {
    await settled(shown);
    await shown.evaluate(() => octavo.store.set({ hasAnnotations: false }));
    await shown.waitForTimeout(200);
    const middle = async () => {
      const { grey, width, height } = pngPixels(await shown.locator("#panel-z").screenshot());
      return Math.max(...[-1, 0, 1].map(
        (dy) => grey[(Math.floor(height / 2) + dy) * width + Math.floor(width / 2)]));
    };
    assert.match(await text(shown, "fidelity"), /^1\/\d+ shown/);
    assert.ok(Math.abs(await middle() - 175) <= 3, `${await middle()}`);
    await shown.evaluate(() => octavo.slices[2].zoomAt([150_000, 2, 2], 1e5));
    await shown.waitForFunction(
      () => document.getElementById("fidelity").textContent.startsWith("full resolution"));
    await shown.waitForTimeout(200);
    assert.ok(Math.abs(await middle() - 175) <= 1, `${await middle()}`);
    assert.ok(await shown.evaluate(() => octavo.slices[2].look.pixelMm < 0.1));
    await shown.evaluate(() => octavo.store.set({ layout: "3d", mode: "mip" }));
    await settled(shown);
  });
});

test("equal voxels are said to be equal", async () => {
  host.files.set("/equal.8vo", await builtRaw(Uint8Array.of(7), [1, 1, 1]));
  await withPage("?url=equal.8vo", async (shown) => {
    await settled(shown);
    assert.match(await text(shown, "message"), /^All voxels of equal\.8vo have the value 7\./);
    assert.equal(await text(shown, "readout"), "voxel 0, 0, 0 · 0.0, 0.0, 0.0 mm · 7");
  });
});

test("numbers are those of the scan, and of the window behind its link", async () => {
  const side = 16;
  const first = 3913030420;
  const voxels = Uint32Array.from({ length: side ** 3 }, (_, i) => first + (i % 97));
  host.files.set("/large.8vo", await builtRaw(voxels, [side, side, side]));
  const query = "?url=large.8vo&at=5,0,0&layout=z&mode=iso&window=3913030468.5,95&iso=3913030470";
  await withPage(query, async (shown) => {
    const fields = () => shown.evaluate(() =>
      ["center", "width", "iso"].map((id) => document.getElementById(id).value));
    await settled(shown);
    assert.match(await text(shown, "readout"), / · 3913030425 · /);
    assert.match(await text(shown, "facts"), /3913030420 to 3913030516/);
    assert.deepEqual(await fields(), ["3913030468.5", "95", "3913030470"]);
    const before = pngPixels(await panelPng(shown, "panel-z")).grey;
    // Who leaves a field as it is changes nothing.
    await shown.locator("#center").focus();
    await shown.locator("#center").dispatchEvent("change");
    await shown.goto(await shown.evaluate(() => octavo.permalink()));
    await settled(shown);
    assert.deepEqual(await fields(), ["3913030468.5", "95", "3913030470"]);
    assert.deepEqual(pngPixels(await panelPng(shown, "panel-z")).grey, before);
  });
});

test("values too small for graphics cards are drawn, one value as octavo slice does", async () => {
  const middle = async (shown) => {
    const { grey, width, height } = pngPixels(await panelPng(shown, "panel-z"));
    return [0.25, 0.75].map(
      (at) => grey[Math.floor(height / 2 - 20) * width + Math.floor(width / 2 + (at - 0.5) * 200)]);
  };
  const tiny = Float32Array.from({ length: 512 }, (_, i) => (i % 8 < 4 ? 5e-43 : 1e-42));
  host.files.set("/tiny.8vo", await builtRaw(tiny, [8, 8, 8]));
  await withPage("?url=tiny.8vo&layout=z&window=5e-43,1e-42", async (shown) => {
    await settled(shown);
    const [left, right] = await middle(shown);
    assert.ok(Math.abs(left - 128) <= 2 && right === 255, `${left}, ${right}`);
  });
  host.files.set("/seven.8vo", await builtRaw(new Uint8Array(512).fill(7), [8, 8, 8]));
  await withPage("?url=seven.8vo&layout=z", async (shown) => {
    await settled(shown);
    assert.deepEqual(await middle(shown), [255, 255]);
  });
});

test("a scan without a finite value is said to be one", async () => {
  const nowhere = await builtRaw(new Float32Array(1000).fill(NaN), [10, 10, 10]);
  host.files.set("/nowhere.8vo", nowhere);
  await withPage("?url=nowhere.8vo", async (shown) => {
    await settled(shown);
    assert.match(await text(shown, "message"), /^All voxels of nowhere\.8vo are NaN or infinite\./);
  });
});

test("each of many listed files can be scrolled to and opened", async () => {
  const listed = Array.from({ length: 40 }, (_, i) => ({ title: `scan ${i}`, url: "scan.8vo" }));
  host.files.set("/files.json", Buffer.from(JSON.stringify(listed)));
  try {
    await withPage("", async (shown) => {
      const buttons = shown.locator("#listed button");
      await buttons.last().scrollIntoViewIfNeeded();
      await shown.locator("#choose").click({ trial: true });
      await buttons.first().click();
      await settled(shown);
      assert.equal(await text(shown, "title"), "scan.8vo");
    });
  } finally {
    host.files.set("/files.json", Buffer.from("[]"));
  }
});

test("a server that dies is named, and what is missing comes once it is back", async () => {
  // Larger than what opening fetches.
  const noisy = Buffer.from((await builtScan(5)).bytes);
  await withPage("?url=scan.8vo&layout=z", async (shown) => {
    await shown.waitForFunction(() => !document.getElementById("message").hidden);
    const message = await text(shown, "message");
    assert.match(message, /scan\.8vo/);
    host.misbehave = null;
    await shown.locator("#message button").first().click();
    await settled(shown);
    await shown.waitForFunction(
      () => document.getElementById("fidelity").textContent === "full resolution");
    assert.equal(await shown.locator("#message").isVisible(), false);
  }, {
    mayComplain: true,
    prepare: () => {
      let asked = 0;
      host.files.set("/scan.8vo", noisy);
      host.misbehave = (request, response) => {
        if (!request.url.startsWith("/scan.8vo") || ++asked < 4) return false;
        response.writeHead(503).end();
        return true;
      };
    },
  });
});

const isSlow = (shown, state) => shown.locator("#slow").waitFor({ state });

test("a server that trickles is said to be slow until bytes flow", async () => {
  let isFlowing = false;
  await withPage("?url=scan.8vo&layout=z", async (shown) => {
    await isSlow(shown, "visible");
    assert.match(await text(shown, "slow"),
      /^the server is slow: [\d.]+ k?B of [\d.]+ kB after ([5-9]|\d\d+) s Try again$/);
    isFlowing = true;
    await isSlow(shown, "hidden");
    await settled(shown);
    assert.equal(await shown.locator("#message").isHidden(), true);
  }, {
    prepare: () => {
      host.misbehave = async (request, response) => {
        if (!request.url.startsWith("/scan.8vo") || isFlowing) return false;
        const part = beginRange(request, response, files.scan);
        let at = 0;
        for (; !isFlowing && !response.destroyed && at < part.length; at += 10) {
          response.write(part.subarray(at, at + 10));
          await new Promise((resolve) => setTimeout(resolve, 100));
        }
        response.end(part.subarray(at));
        return true;
      };
    },
  });
});

test("a server that falls silent is said to be slow, and asked again by a button", async () => {
  // Larger than what opening fetches.
  const noisy = Buffer.from((await builtScan(5)).bytes);
  let asked = 0;
  await withPage("?url=scan.8vo&layout=z", async (shown) => {
    await isSlow(shown, "visible");
    assert.match(await text(shown, "slow"), /slow: 0 B of [\d.]+ [kM]B after \d+ s/);
    host.misbehave = null;
    await shown.locator("#slow-again").click();
    await isSlow(shown, "hidden");
    await settled(shown);
    assert.equal(await shown.evaluate(() => octavo.session.facts.levels[0].size[0]), 128);
  }, {
    prepare: () => {
      host.files.set("/scan.8vo", noisy);
      // True: somebody else answers, and nobody does.
      host.misbehave = (request) => request.url.startsWith("/scan.8vo") && ++asked >= 4;
    },
  });
});

test("the line names the scan that is being opened, from the start to the first picture", async () => {
  // Larger than what opening fetches.
  const noisy = Buffer.from((await builtScan(5)).bytes);
  const held = [];
  const hold = () => new Promise((go) => { held.push(() => go(false)); });
  const line = (shown) => shown.evaluate(async () => {
    // Frames, and changes of the view, are drawn meanwhile.
    octavo.store.set({ layout: octavo.store.now.layout === "z" ? "four" : "z" });
    await new Promise((resolve) => setTimeout(resolve, 300));
    return document.getElementById("fidelity").textContent;
  });
  await withPage("?url=slow%20scan.8vo", async (shown) => {
    for (const what of ["header", "index", "first slice"]) {
      while (held.length === 0) await shown.waitForTimeout(50);
      assert.match(await line(shown), /^opening slow scan\.8vo …/, what);
      if (what === "header") {
        assert.equal(await text(shown, "welcome-title"), "opening slow scan.8vo …");
      }
      if (what === "first slice") host.misbehave = null;
      for (const go of held.splice(0)) go();
    }
    await settled(shown);
    await shown.waitForFunction(
      () => document.getElementById("fidelity").textContent.startsWith("full resolution"));
    // The next one, beside what is shown.
    host.misbehave = (request) => request.url.startsWith("/late.8vo") && hold();
    await shown.evaluate(() => { octavo.open("late.8vo"); });
    assert.match(await line(shown), /; opening late\.8vo …$/);
  }, {
    mayComplain: true,
    prepare: () => {
      host.files.set("/slow scan.8vo", noisy);
      host.misbehave = (request) => request.url.startsWith("/slow") && hold();
    },
  });
});

/** Requests for a path wait: `asked` settles with the first, `answer` lets all go on. */
function heldBack(path) {
  let answer;
  const isAnswered = new Promise((go) => { answer = () => go(false); });
  const asked = new Promise((resolve) => {
    host.misbehave = (request) => {
      if (!request.url.startsWith(path)) return false;
      resolve();
      return isAnswered;
    };
  });
  return { asked, answer };
}

test("what comes or fails late does not take the place of a scan opened after it", async () => {
  host.files.set("/late.8vo", files.scan);
  host.files.set("/late_labels.8vo", files.labels);
  for (const name of ["late.8vo", "late_labels.8vo", "none.8vo"]) {
    await withPage("", async (shown) => {
      const { asked, answer } = heldBack(`/${name}`);
      await shown.evaluate((late) => { globalThis.late = octavo.open(late); }, name);
      await asked;
      await shown.evaluate(() => octavo.open("scan.8vo"));
      answer();
      await shown.evaluate(() => globalThis.late);
      assert.equal(await text(shown, "title"), "scan.8vo", name);
      assert.equal(await text(shown, "message"), "", name);
      assert.equal(await shown.evaluate(() => octavo.overlay?.facts.name), undefined, name);
    }, { mayComplain: name === "none.8vo" });
  }
});

test("labels of a link do not come over another scan than that of the link", async () => {
  host.files.set("/late_labels.8vo", files.labels);
  for (const name of ["late_labels.8vo", "none.8vo"]) {
    let held;
    await withPage(`?url=scan.8vo&labels=${name}`, async (shown) => {
      await held.asked;
      await shown.evaluate(async () => {
        const bytes = await (await fetch("scan.8vo")).arrayBuffer();
        await octavo.open(new File([bytes], "own.8vo"));
      });
      const answered = shown.waitForResponse((response) => response.url().endsWith(name));
      held.answer();
      await answered;
      await shown.waitForTimeout(500);
      assert.equal(await shown.evaluate(() => octavo.overlay?.facts.name), undefined);
      assert.equal(await text(shown, "message"), "");
      assert.equal(await shown.evaluate(() => location.search), "");
    }, { mayComplain: name === "none.8vo", prepare: () => { held = heldBack(`/${name}`); } });
  }
});

test("a file that is replaced is never mixed with the one that is shown", async () => {
  const [noisy, other] = [5, 6].map(async (seed) => Buffer.from((await builtScan(seed)).bytes));
  const before = await noisy;
  const after = await other;
  await withPage("?url=scan.8vo&layout=z&at=75,65,10", async (shown) => {
    await shown.waitForFunction(() => globalThis.octavo?.session?.hasPreview);
    host.files.set("/scan.8vo", after);
    await shown.evaluate(() => octavo.store.set({ at: [10, 10, 70], layout: "y" }));
    await shown.waitForFunction(() => !document.getElementById("message").hidden);
    const open = shown.locator("#message button", { hasText: "Open the new file" });
    await open.waitFor();
    await open.click();
    await settled(shown);
    assert.equal(await shown.evaluate(() => octavo.session.facts.levels[0].size[0]), 128);
    assert.equal(await shown.evaluate(() => octavo.session.cells.failure ?? null), null);
  }, { mayComplain: true, prepare: () => host.files.set("/scan.8vo", before) });
});

test("a file that was replaced does not take the place of a scan opened after it", async () => {
  const [before, after] = await Promise.all([5, 6].map(async (seed) =>
    Buffer.from((await builtScan(seed)).bytes)));
  host.files.set("/late.8vo", files.scan);
  for (const isPressed of [true, false]) {
    await withPage("?url=scan.8vo&layout=z&at=75,65,10", async (shown) => {
      await shown.waitForFunction(() => globalThis.octavo?.session?.hasPreview);
      const late = isPressed ? undefined : heldBack("/late.8vo");
      if (late) {
        await shown.evaluate(() => { globalThis.late = octavo.open("late.8vo"); });
        await late.asked;
      }
      host.files.set("/scan.8vo", after);
      await shown.evaluate(() => octavo.store.set({ at: [10, 10, 70], layout: "y" }));
      const open = shown.locator("#message button", { hasText: "Open the new file" });
      await open.waitFor();
      if (late) {
        late.answer();
        await shown.evaluate(() => globalThis.late);
      } else {
        const reopened = heldBack("/scan.8vo");
        await open.click();
        await reopened.asked;
        await shown.evaluate(() => octavo.open("late.8vo"));
        const answered = shown.waitForResponse((response) => response.url().endsWith("/scan.8vo"));
        reopened.answer();
        await answered;
        await shown.waitForTimeout(500);
      }
      await settled(shown);
      assert.equal(await text(shown, "title"), "late.8vo");
      assert.equal(await text(shown, "message"), "");
    }, { mayComplain: true, prepare: () => host.files.set("/scan.8vo", before) });
  }
});

test("lies and damage are a sentence, and the next file opens", async () => {
  const damaged = Buffer.from(files.scan);
  for (let i = 0; i < 64; ++i) damaged[Math.floor(damaged.length / 2) + i * 97] ^= 0xff;
  await withPage("", async (shown) => {
    await shown.locator("#welcome").waitFor();
    for (const [name, bytes] of [
      ["none.8vo", null], ["text.8vo", Buffer.from("hello ".repeat(200))],
      ["short.8vo", files.scan.subarray(0, 5000)],
      ["shifted.8vo", Buffer.concat([Buffer.from([0]), files.scan])],
      ["zeros.8vo", Buffer.concat([files.scan.subarray(0, -200), Buffer.alloc(200)])],
    ]) {
      if (bytes) host.files.set(`/${name}`, bytes);
      await shown.evaluate((url) => octavo.open(url), `${host.url}/${name}`);
      const message = await text(shown, "message");
      assert.ok(message.length > 20 && message.length < 400, message);
      if (name === "zeros.8vo") assert.match(message, /damaged/);
      // What was sent wrongly may be sent rightly now.
      if (!bytes) continue;
      host.files.set(`/${name}`, files.scan);
      await shown.locator("#message button", { hasText: "Try again" }).click();
      await settled(shown);
      assert.equal(await text(shown, "title"), name);
    }
    host.files.set("/damaged.8vo", damaged);
    await shown.evaluate((url) => octavo.open(url), `${host.url}/damaged.8vo`);
    await shown.waitForFunction(
      () => document.getElementById("message").textContent.includes("damaged.8vo"));
    await shown.evaluate((url) => octavo.open(url), `${host.url}/scan.8vo`);
    await settled(shown);
    assert.equal(await shown.evaluate(() => octavo.session.facts.name.includes("scan.8vo")), true);
  }, { mayComplain: true });
});

test("a server that ignores ranges is said to do so, and the file is shown", async () => {
  await withPage("?url=scan.8vo&layout=z", async (shown) => {
    await settled(shown);
    assert.match(await text(shown, "message"), /range/i);
  }, { prepare: () => { host.ignoresRanges = true; } });
});

test("flying through keeps decoded voxels within their limit", async () => {
  await withPage("?url=scan.8vo", async (shown) => {
    await settled(shown);
    const limit = await shown.evaluate(() => octavo.session.cells.budgetBytes);
    let most = 0;
    for (let i = 0; i < 60; ++i) {
      await shown.evaluate((n) => octavo.store.set({
        at: [(n * 41) % 150, (n * 31) % 130, (n * 7) % 90],
        camera: { azimuth: n * 6 - 180, elevation: (n * 5) % 60, zoom: 1 + (n % 3) },
      }), i);
      await shown.waitForTimeout(30);
      most = Math.max(most, await shown.evaluate(() => octavo.session.cells.heldBytes));
    }
    assert.ok(most > 0 && most <= limit, `${most} of ${limit}`);
  });
});

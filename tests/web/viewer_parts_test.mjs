// What the viewer is made of, without a browser: the tests of web/viewer, and its size.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { root } from "./support/golden.mjs";

test("every test of web/viewer passes", () => {
  const viewer = join(root, "web/viewer");
  execFileSync("node", ["build.mjs", "--tests"], { cwd: viewer, stdio: "inherit" });
  const folder = join(viewer, "dist/tests");
  const names = readdirSync(folder).filter((name) => name.endsWith(".test.mjs"));
  if (names.length === 0) throw new Error("there are no tests");
  const paths = names.map((name) => join(folder, name));
  // Its environment marks a test that runs within another one.
  const { NODE_TEST_CONTEXT, ...env } = process.env;
  execFileSync("node", ["--test", "--test-reporter=dot", ...paths], { stdio: "inherit", env });
});

test("the scripts of the page stay below 60 kB as gzip", () => {
  const sizes = ["viewer.js", "worker.js"].map((name) =>
    gzipSync(readFileSync(join(root, "web/viewer/dist", name)), { level: 9 }).length);
  assert.ok(sizes[0] + sizes[1] < 60_000, `${sizes}`);
});

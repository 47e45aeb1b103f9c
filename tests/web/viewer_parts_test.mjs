// What the viewer is made of, without a browser: the tests of web/viewer.
import { execFileSync } from "node:child_process";
import { readdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
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

import assert from "node:assert/strict";
import test from "node:test";
import {
  parsePermalink,
  permalinkText,
  rejectedAddresses,
  safeUrl,
} from "../src/store/permalink.js";

const base = "https://example.org/scans/";

test("a link holds a view, and gives it back", () => {
  const link = {
    url: `${base}head%20scan.8vo`,
    at: [12, 0, 7],
    window: { center: 40, width: 80 },
    layout: "z",
    mode: "iso",
    iso: 226,
    camera: { azimuth: -30, elevation: 12.5, zoom: 2 },
    opacity: 0.4,
    isNeurological: true,
    labels: "https://other.example/l.8vo?x=1&y=2",
  } as const;
  const text = permalinkText(link, base);
  assert.ok(text.startsWith("?url=head%2520scan.8vo&labels=https://other.example/l.8vo"));
  assert.deepEqual(parsePermalink(text, base), link);
});

test("whatever else stands in an address is left out", () => {
  const bad =
    "?url=javascript:alert(1)&labels=data:text/html,x&at=1,2&window=<b>,1&layout=five" +
    "&mode=volumes&iso=x&camera=1,2,0&opacity=&side=left&unknown=1";
  assert.deepEqual(parsePermalink(bad, base), {});
  assert.equal(parsePermalink("?opacity=7&camera=0,500,1", base).opacity, 1);
  assert.equal(parsePermalink("?camera=0,500,1", base).camera!.elevation, 90);
  assert.equal(safeUrl("http://[", base), undefined);
  assert.equal(safeUrl("a.8vo", base), `${base}a.8vo`);
  assert.equal(permalinkText({}, base), "");
});

test("an address that is not taken is a sentence", () => {
  for (const text of ["javascript:alert(1)", "data:text/html,x", "file:///a", "http://["]) {
    const rejected = rejectedAddresses(`?url=${text}&labels=a.8vo`, base);
    assert.deepEqual([...rejected], [
      ["url", `url=${text} was rejected: only http and https addresses are opened`],
    ]);
  }
  assert.deepEqual([...rejectedAddresses("?url=a.8vo&labels=data:x", base).keys()], ["labels"]);
  assert.equal(rejectedAddresses("?url=a.8vo&labels=https://b/c.8vo", base).size, 0);
  assert.equal(rejectedAddresses("?at=1,2,3", base).size, 0);
});

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
    clip: { lo: [0, 3, 1], hi: [128, 256, 108] },
    curve: [
      { value: -150.5, color: [214, 8, 128], opacity: 0 },
      { value: 300, color: [255, 255, 255], opacity: 0.75 },
    ],
    hidden: new Set([2, 7, 8, 9, 4294967295]),
    labels: "https://other.example/l.8vo?x=1&y=2",
  } as const;
  const text = permalinkText(link, base);
  assert.ok(text.startsWith("?url=head%2520scan.8vo&labels=https://other.example/l.8vo"));
  assert.deepEqual(parsePermalink(text, base), link);
  assert.ok(
    text.includes(
      "&clip=0:128,3:256,1:108&curve=-150.5:0:d60880,300:0.75:ffffff&hide=2,7-9,4294967295&",
    ),
    text,
  );
  for (const curve of ["bone", "auto"]) {
    assert.deepEqual(parsePermalink(permalinkText({ curve }, base), base), { curve });
  }
});

test("an address in a link is that of its file, short where that is the same", () => {
  for (const [name, short] of [
    ["a.8vo", "a.8vo"], ["b/a:b.8vo", "b/a:b.8vo"], ["a:b.8vo", undefined],
    ["https:a.8vo", undefined], ["javascript:a", undefined], ["//a.8vo", undefined],
    ["//[", undefined], ["/a.8vo", undefined], ["?a=1", undefined], ["", undefined],
  ] as const) {
    const url = base + name;
    const text = permalinkText({ url, labels: url }, `${base}index.html?x#y`);
    const found = parsePermalink(text, `${base}index.html`);
    assert.deepEqual(found, { url, labels: url }, text);
    if (short) assert.equal(text, `?url=${short}&labels=${short}`);
  }
});

test("parts of other names stay in a link as they were", () => {
  const of = (search: string): string => permalinkText({ layout: "z" }, base, search);
  assert.equal(of("?token=a%20b+c&url=x&u%72l=y&at=1&layout=x&&flag&=&t=%"),
    "?layout=z&token=a%20b+c&flag&=&t=%");
  assert.equal(of(""), "?layout=z");
  assert.equal(permalinkText({}, base, "?hide=2&token=1"), "?token=1");
});

test("clip boxes, curves and hidden labels that are none are left out", () => {
  const of = (query: string): object => parsePermalink(`?${query}`, base);
  for (const clip of [
    "", "1:2", "0:1,0:1,1:1", "0:1,0:1,2:1", "0:1,0:1,x:1", "0:1,0:1,0:0.4", "0,1,0,1,0,1",
  ]) {
    assert.deepEqual(of(`clip=${clip}`), {}, clip);
  }
  for (const curve of [
    "", "nose", "1:0:ffffff", "2:0:ffffff,1:0:ffffff", "1:0:ffffff,2:2:ffffff",
    "1:0:fffff,2:1:ffffff", "NaN:0:ffffff,2:1:ffffff", "1::ffffff,2:1:ffffff",
    Array.from({ length: 65 }, (_, i) => `${i}:0:ffffff`).join(),
  ]) {
    assert.deepEqual(of(`curve=${curve}`), {}, curve);
  }
  for (const hide of ["", "x", "-1", "3-2", "0-4294967295", "1,,2", "1-9999,20000-29999"]) {
    assert.deepEqual(of(`hide=${hide}`), {}, hide);
  }
});

test("numbers of a link may have signs, spaces and exponents", () => {
  const of = (query: string): object => parsePermalink(`?${query}`, base);
  assert.deepEqual(of("iso=+226"), { iso: 226 });
  assert.deepEqual(of("at=+1, 2,%2B3"), { at: [1, 2, 3] });
  assert.deepEqual(of("window=1e+3,+2e+2"), { window: { center: 1000, width: 200 } });
  assert.deepEqual(of("clip=-3:+4,0:1e+1,1.2:8"), { clip: { lo: [-3, 0, 1], hi: [4, 10, 8] } });
  for (const iso of ["1 2", "1++2", "+", "1e", "--1"]) assert.deepEqual(of(`iso=${iso}`), {}, iso);
});

test("parts of a link that are not understood are told", () => {
  const wrongOf = (query: string): string[] => {
    const wrong: string[] = [];
    parsePermalink(`?${query}`, base, wrong);
    return wrong;
  };
  assert.deepEqual(
    wrongOf(
      "layout=q&at=1,2&clip=1:2&curve=nose&hide=x&mode=a&iso=b&camera=1,2,0&opacity=c&side=up",
    ),
    [
      "at=1,2", "layout=q", "mode=a", "iso=b", "camera=1,2,0", "opacity=c", "clip=1:2",
      "curve=nose", "hide=x", "side=up",
    ],
  );
  assert.deepEqual(wrongOf("window=<b>,1"), ["window=<b>,1"]);
  assert.deepEqual(wrongOf(`iso=${"x".repeat(99)}`), [`iso=${"x".repeat(60)}…`]);
  for (const query of ["", "hide=&iso=", "other=1", "side=radiological", "url=data:x"]) {
    assert.deepEqual(wrongOf(query), [], query);
  }
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

test("numbers of a link are read as the same numbers", () => {
  const link = {
    window: { center: 1.0000046889, width: 7.47e-6 },
    iso: 16777219,
    opacity: 0.12345678,
    curve: [
      { value: 1.0000011, color: [1, 2, 3], opacity: 0.30000001 },
      { value: 1e21, color: [4, 5, 6], opacity: 1 },
    ],
  } as const;
  const base = "https://a.org/";
  assert.deepEqual(parsePermalink(permalinkText(link, base), base), link);
});

// A view as text behind the address of the page, and back.
//
//     ?url=scan.8vo&at=128,40,60&window=bone&layout=z&mode=iso&iso=226
//     ?url=scan.8vo&labels=organs.8vo&hide=2,7-40&clip=0:128,0:256,0:108&curve=bone
//     ?url=scan.8vo&curve=150:0:d6a880,500:0.7:faecd4    value : opacity : color of each point
//
// Whatever comes from an address is only ever taken as numbers, as one of a list of words, or as a
// URL to fetch.
import { type Box, type Vec3 } from "../reader/volume.js";
import { type Camera } from "../view/camera.js";
import { type Transfer, type TransferPoint, TRANSFER_PRESETS } from "../view/transfer.js";
import { type Window, numbers, parseWindow, windowText } from "../view/window.js";

export const LAYOUTS = ["four", "x", "y", "z", "3d"] as const;
export type Layout = (typeof LAYOUTS)[number];
export const MODES = ["iso", "mip", "volume"] as const;
export type Mode = (typeof MODES)[number];

export interface Permalink {
  url?: string;
  labels?: string;
  /** A voxel of level 0. */
  at?: Vec3;
  window?: Window;
  layout?: Layout;
  mode?: Mode;
  iso?: number;
  camera?: Camera;
  opacity?: number;
  isNeurological?: boolean;
  /** Voxels of level 0. */
  clip?: Box;
  /** The name of a preset, or points. */
  curve?: string | Transfer;
  hidden?: ReadonlySet<number>;
}

const MOST_CURVE_POINTS = 64;
const MOST_HIDDEN = 10_000;

/** "0:128,0:256,0:108": first and one behind the last voxel of each axis. */
function parseClip(text: string): Box | undefined {
  const ends = text
    .split(",")
    .map((part) => numbers(part.replaceAll(":", ","), 2)?.map(Math.round));
  if (ends.length !== 3 || !ends.every((end) => end && end[0]! < end[1]!)) return undefined;
  return {
    lo: ends.map((end) => end![0]) as unknown as Vec3,
    hi: ends.map((end) => end![1]) as unknown as Vec3,
  };
}

function clipText(clip: Box): string {
  return clip.lo.map((lo, a) => `${lo}:${clip.hi[a as 0]}`).join(",");
}

function parseCurve(text: string): string | Transfer | undefined {
  if (TRANSFER_PRESETS.has(text) || text === "auto") return text;
  const points = text.split(",").map((part): TransferPoint | undefined => {
    const fields = /^([^:]+):([^:]+):([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i.exec(part);
    const [value, opacity] = numbers(fields && `${fields[1]},${fields[2]}`, 2) ?? [];
    if (!fields || opacity === undefined || opacity < 0 || opacity > 1) return undefined;
    const color = fields.slice(3).map((hex) => parseInt(hex, 16)) as unknown as Vec3;
    return { value: value!, color, opacity };
  });
  const isRight =
    points.length >= 2 && points.length <= MOST_CURVE_POINTS &&
    points.every((p, i) => p && (i === 0 || points[i - 1]!.value <= p.value));
  return isRight ? (points as Transfer) : undefined;
}

function curveText(curve: string | Transfer): string {
  if (typeof curve === "string") return curve;
  const hex = (c: number): string => Math.round(c).toString(16).padStart(2, "0");
  return curve
    .map((p) => `${p.value}:${p.opacity}:${p.color.map(hex).join("")}`)
    .join(",");
}

/** "2,7-40"; nothing where that is not what it is, or too many. */
function parseHidden(text: string): ReadonlySet<number> | undefined {
  const hidden = new Set<number>();
  for (const part of text.split(",")) {
    const ends = /^(\d{1,10})(?:-(\d{1,10}))?$/.exec(part);
    if (!ends) return undefined;
    const [first, last] = [Number(ends[1]), Number(ends[2] ?? ends[1])];
    if (last < first || hidden.size + last - first >= MOST_HIDDEN) return undefined;
    for (let label = first; label <= last; ++label) hidden.add(label);
  }
  return hidden;
}

function hiddenText(hidden: ReadonlySet<number>): string | undefined {
  if (hidden.size === 0 || hidden.size > MOST_HIDDEN) return undefined;
  const parts: string[] = [];
  const labels = [...hidden].sort((a, b) => a - b);
  for (let i = 0; i < labels.length; ) {
    let next = i + 1;
    while (labels[next] === labels[next - 1]! + 1) next += 1;
    parts.push(next === i + 1 ? `${labels[i]}` : `${labels[i]}-${labels[next - 1]}`);
    i = next;
  }
  return parts.join(",");
}

function startOf(text: string): string {
  return text.length > 60 ? `${text.slice(0, 60)}…` : text;
}

/** A URL that may be fetched: relative to the page, or http and https. */
export function safeUrl(text: string | null, base: string): string | undefined {
  if (!text) return undefined;
  try {
    const url = new URL(text, base);
    return url.protocol === "http:" || url.protocol === "https:" ? url.href : undefined;
  } catch {
    return undefined;
  }
}

/** A sentence for each address of a link that is not taken. */
export function rejectedAddresses(search: string, base: string): Map<"url" | "labels", string> {
  const query = new URLSearchParams(search);
  const rejected = new Map<"url" | "labels", string>();
  for (const key of ["labels", "url"] as const) {
    const text = query.get(key);
    if (!text || safeUrl(text, base) !== undefined) continue;
    const what = `${key}=${startOf(text)} was rejected`;
    rejected.set(key, `${what}: only http and https addresses are opened`);
  }
  return rejected;
}

function parseCamera(text: string): Camera | undefined {
  const [azimuth, elevation, zoom] = numbers(text, 3) ?? [];
  if (!(zoom! > 0)) return undefined;
  return { azimuth: azimuth!, elevation: Math.max(-90, Math.min(90, elevation!)), zoom: zoom! };
}

function parseOpacity(text: string): number | undefined {
  const opacity = numbers(text, 1)?.[0];
  return opacity === undefined ? undefined : Math.max(0, Math.min(1, opacity));
}

function parseSide(text: string): boolean | undefined {
  return text === "neurological" || (text === "radiological" ? false : undefined);
}

/** What the parts of a link but its addresses stand for; undefined where that is nothing. */
const PARTS: readonly [string, keyof Permalink, (text: string) => unknown][] = [
  ["at", "at", (text) => numbers(text, 3)?.map(Math.round)],
  ["window", "window", parseWindow],
  ["layout", "layout", (text) => LAYOUTS.find((word) => word === text)],
  ["mode", "mode", (text) => MODES.find((word) => word === text)],
  ["iso", "iso", (text) => numbers(text, 1)?.[0]],
  ["camera", "camera", parseCamera],
  ["opacity", "opacity", parseOpacity],
  ["clip", "clip", parseClip],
  ["curve", "curve", parseCurve],
  ["hide", "hidden", parseHidden],
  ["side", "isNeurological", parseSide],
];

const NAMES = ["url", "labels", ...PARTS.map(([name]) => name)];

/** Parts that are not understood are left out, and put into `wrong`. */
export function parsePermalink(search: string, base: string, wrong: string[] = []): Permalink {
  const query = new URLSearchParams(search);
  const found: Partial<Record<keyof Permalink, unknown>> = {};
  for (const key of ["url", "labels"] as const) {
    const url = safeUrl(query.get(key), base);
    if (url) found[key] = url;
  }
  for (const [key, field, parse] of PARTS) {
    const text = query.get(key);
    const value = text && parse(text);
    if (value === undefined) wrong.push(`${key}=${startOf(text!)}`);
    else if (text) found[field] = value;
  }
  return found as Permalink;
}

/**
 * The query of a link, in a fixed order; URLs stay readable where they can. Behind it stand the
 * parts of other names that `search`, the query before, has.
 */
export function permalinkText(link: Permalink, base: string, search = ""): string {
  const parts: string[] = [];
  const put = (key: string, value: string | undefined): void => {
    if (value === undefined) return;
    parts.push(
      `${key}=${encodeURIComponent(value).replace(/%(2F|2C|3A)/g, decodeURIComponent)}`,
    );
  };
  const relative = (url: string | undefined): string | undefined => {
    const folder = new URL(".", base).href;
    const short = url?.startsWith(folder) ? url.slice(folder.length) : "";
    // Not every name is an address of its own: "a:b.8vo" has a scheme, "//a.8vo" a host.
    return url && safeUrl(short, base) === url ? short : url;
  };
  put("url", relative(link.url));
  put("labels", relative(link.labels));
  put("at", link.at?.join(","));
  put("window", link.window && windowText(link.window));
  put("layout", link.layout === "four" ? undefined : link.layout);
  put("mode", link.mode);
  put("iso", link.iso === undefined ? undefined : String(link.iso));
  const c = link.camera;
  put(
    "camera",
    c && [c.azimuth, c.elevation, c.zoom].map((v) => Number(v.toPrecision(4))).join(","),
  );
  put("opacity", link.opacity === undefined ? undefined : String(link.opacity));
  put("clip", link.clip && clipText(link.clip));
  put("curve", link.curve === undefined ? undefined : curveText(link.curve));
  put("hide", link.hidden && hiddenText(link.hidden));
  if (link.isNeurological) put("side", "neurological");
  for (const part of search.replace("?", "").split("&")) {
    const [name] = new URLSearchParams(part).keys();
    if (name !== undefined && !NAMES.includes(name)) parts.push(part);
  }
  return parts.length > 0 ? `?${parts.join("&")}` : "";
}

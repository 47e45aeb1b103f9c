// A view as text behind the address of the page, and back.
//
//     ?url=scan.8vo&at=128,40,60&window=bone&layout=z&mode=iso&iso=226
//
// Whatever comes from an address is only ever taken as numbers, as one of a list of words, or as a
// URL to fetch.
import { type Vec3 } from "../reader/volume.js";
import { type Camera } from "../view/camera.js";
import { type Window, parseWindow, shortNumber, windowText } from "../view/window.js";

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
}

function numbers(text: string | null, count: number): number[] | undefined {
  if (text === null) return undefined;
  const parts = text.split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
  return parts.length === count && parts.every(Number.isFinite) ? parts : undefined;
}

function oneOf<T extends string>(text: string | null, words: readonly T[]): T | undefined {
  return words.find((word) => word === text);
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
    const start = text.length > 60 ? `${text.slice(0, 60)}…` : text;
    rejected.set(key, `${key}=${start} was rejected: only http and https addresses are opened`);
  }
  return rejected;
}

export function parsePermalink(search: string, base: string): Permalink {
  const query = new URLSearchParams(search);
  const link: Permalink = {};
  const put = <K extends keyof Permalink>(key: K, value: Permalink[K] | undefined): void => {
    if (value !== undefined) link[key] = value;
  };
  put("url", safeUrl(query.get("url"), base));
  put("labels", safeUrl(query.get("labels"), base));
  const at = numbers(query.get("at"), 3);
  if (at) link.at = at.map(Math.round) as unknown as Vec3;
  put("window", parseWindow(query.get("window") ?? ""));
  put("layout", oneOf(query.get("layout"), LAYOUTS));
  put("mode", oneOf(query.get("mode"), MODES));
  put("iso", numbers(query.get("iso"), 1)?.[0]);
  const camera = numbers(query.get("camera"), 3);
  if (camera && camera[2]! > 0) {
    const [azimuth, elevation, zoom] = camera as [number, number, number];
    link.camera = { azimuth, elevation: Math.max(-90, Math.min(90, elevation)), zoom };
  }
  const opacity = numbers(query.get("opacity"), 1)?.[0];
  if (opacity !== undefined) link.opacity = Math.max(0, Math.min(1, opacity));
  if (query.get("side") === "neurological") link.isNeurological = true;
  return link;
}

/** The query of a link, in a fixed order; URLs stay readable where they can. */
export function permalinkText(link: Permalink, base: string): string {
  const parts: string[] = [];
  const put = (key: string, value: string | undefined): void => {
    if (value === undefined) return;
    parts.push(
      `${key}=${encodeURIComponent(value).replace(/%(2F|2C|3A)/g, decodeURIComponent)}`,
    );
  };
  const relative = (url: string | undefined): string | undefined => {
    const folder = new URL(".", base).href;
    return url?.startsWith(folder) ? url.slice(folder.length) : url;
  };
  put("url", relative(link.url));
  put("labels", relative(link.labels));
  put("at", link.at?.join(","));
  put("window", link.window && windowText(link.window));
  put("layout", link.layout === "four" ? undefined : link.layout);
  put("mode", link.mode);
  put("iso", link.iso === undefined ? undefined : shortNumber(link.iso));
  const c = link.camera;
  put(
    "camera",
    c && [c.azimuth, c.elevation, c.zoom].map((v) => Number(v.toPrecision(4))).join(","),
  );
  put("opacity", link.opacity === undefined ? undefined : shortNumber(link.opacity));
  if (link.isNeurological) put("side", "neurological");
  return parts.length > 0 ? `?${parts.join("&")}` : "";
}

// Slices on the screen: stored values in a texture, interpolated and windowed by a shader.
//
// Two planes lie over each other: a coarse one that is whole, and above it the wanted one, of which
// parts may still be missing. Colors of labels come last.
import { type VolumeFacts } from "../reader/volume.js";
import { Cover, type Gl, nearestTexture } from "./gl.js";
import { type Orientation } from "./geometry.js";
import { type Plane, textureUnit, textureValues } from "./slice_plane.js";
import { type Window, powerOfTwo } from "./window.js";

const SHADER = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D base, fine, colors;
uniform vec4 baseMap, fineMap, colorMap;  // sample = pixel * xy + zw, along across and down
uniform vec4 baseRect, fineRect, colorRect;  // first sample and size of the texture
uniform vec2 corner;  // of the viewport, its upper left, in the pixels of gl_FragCoord
uniform vec4 inside;  // pixels that show the volume: lo, hi
uniform vec2 window;  // black, and 1 / width, in a unit of its own
uniform vec2 real;    // slope, intercept, in that unit
uniform float colorShare;
uniform bool isLabels, hasColors;
out vec4 color;

const float MISSING = 2.95e38;
const float NOT_A_NUMBER = -2.95e38;

float texel(sampler2D plane, vec4 rect, ivec2 at) {
  ivec2 last = ivec2(rect.zw) - 1;
  return texelFetch(plane, clamp(at - ivec2(rect.xy), ivec2(0), last), 0).r;
}

// .x the value, .y 1 where it is known, .z 1 where it is a number
vec3 valueAt(sampler2D plane, vec4 rect, vec2 at) {
  ivec2 low = ivec2(floor(at));
  vec2 share = at - vec2(low);
  float a = texel(plane, rect, low), b = texel(plane, rect, low + ivec2(1, 0));
  float c = texel(plane, rect, low + ivec2(0, 1)), d = texel(plane, rect, low + ivec2(1, 1));
  float most = max(max(a, b), max(c, d)), smallest = min(min(a, b), min(c, d));
  float known = most > MISSING ? 0.0 : 1.0;
  float number = smallest < NOT_A_NUMBER ? 0.0 : 1.0;
  return vec3(mix(mix(a, b, share.x), mix(c, d, share.x), share.y), known, number);
}

void main() {
  vec2 pixel = vec2(gl_FragCoord.x - corner.x, corner.y - gl_FragCoord.y);
  if (any(lessThan(pixel, inside.xy)) || any(greaterThan(pixel, inside.zw))) discard;
  color = vec4(0.0, 0.0, 0.0, 1.0);
  if (!isLabels) {
    vec3 found = valueAt(fine, fineRect, pixel * fineMap.xy + fineMap.zw);
    if (found.y < 0.5) found = valueAt(base, baseRect, pixel * baseMap.xy + baseMap.zw);
    float share = (found.x * real.x + real.y - window.x) * window.y;
    float grey = floor(255.0 * clamp(share, 0.0, 1.0) + 0.5) / 255.0;
    color = vec4(vec3(grey * found.y * found.z), 1.0);
  }
  if (hasColors) {
    vec2 at = floor(pixel * colorMap.xy + colorMap.zw + 0.5);
    ivec2 place = ivec2(at - colorRect.xy);
    if (all(greaterThanEqual(place, ivec2(0))) && all(lessThan(place, ivec2(colorRect.zw)))) {
      vec4 label = texelFetch(colors, place, 0);
      color.rgb = mix(color.rgb, label.rgb, label.a * colorShare);
    }
  }
}`;

/** A rectangle of the screen in device pixels, from the upper left of the canvas. */
export interface Viewport {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** Where a slice stands in a viewport: voxel = first + pixel * step, pixels from its upper left. */
export interface SliceMap {
  readonly first: readonly [number, number];
  readonly step: readonly [number, number];
}

/** A texture that follows a plane, or the colors made of one. */
export class PlaneTexture {
  private readonly texture: WebGLTexture;
  private shown: object | undefined;
  rect: readonly [number, number, number, number] = [0, 0, 1, 1];
  level = 0;

  constructor(private readonly gl: Gl) {
    this.texture = nearestTexture(gl, gl.TEXTURE_2D);
  }

  private put(source: object, plane: Plane, upload: () => void): void {
    if (this.shown === source) return;
    this.shown = source;
    const gl = this.gl;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    upload();
    this.rect = [plane.from[0], plane.from[1], plane.size[0], plane.size[1]];
    this.level = plane.level;
  }

  /** unit  that of the values in the texture: textureUnit of the volume */
  values(plane: Plane, unit: number): void {
    const gl = this.gl;
    const [w, h] = plane.size;
    this.put(plane, plane, () => {
      const floats = textureValues(plane, unit);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32F, w, h, 0, gl.RED, gl.FLOAT, floats);
    });
  }

  colors(plane: Plane, pixels: Uint8Array): void {
    const gl = this.gl;
    const [w, h] = plane.size;
    this.put(pixels, plane, () =>
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, w, h, 0, gl.RGBA, gl.UNSIGNED_BYTE, pixels),
    );
  }

  get handle(): WebGLTexture {
    return this.texture;
  }

  dispose(): void {
    this.gl.deleteTexture(this.texture);
  }
}

export interface SliceTextures {
  readonly base: PlaneTexture;
  readonly fine: PlaneTexture;
  readonly colors: PlaneTexture;
}

/** Gives their memory back at once; what is only forgotten stays until it is collected. */
export function disposeTextures(textures: SliceTextures): void {
  for (const texture of [textures.base, textures.fine, textures.colors]) texture.dispose();
}

export interface SliceDrawing {
  readonly facts: VolumeFacts;
  readonly orientation: Orientation;
  readonly map: SliceMap;
  readonly textures: SliceTextures;
  readonly window: Window;
  readonly isLabels: boolean;
  /** The volume whose labels are drawn, and the map to its voxels; absent: none. */
  readonly colors:
    { facts: VolumeFacts; orientation: Orientation; map: SliceMap; share: number } | undefined;
}

/** From pixels to samples of a level, which lie at the centers of the voxels they stand for. */
export function sampleMap(
  facts: VolumeFacts,
  o: Orientation,
  level: number,
  map: SliceMap,
): [number, number, number, number] {
  const f = facts.levels[level]!.factor;
  const [fx, fy] = [f[o.across], f[o.down]];
  return [
    map.step[0] / fx,
    map.step[1] / fy,
    (map.first[0] + 0.5) / fx - 0.5,
    (map.first[1] + 0.5) / fy - 0.5,
  ];
}

/** The pixels that lie in the volume: outermost voxels reach half a voxel beyond their centers.
 *  What is thinner than a pixel is drawn one pixel thick. */
function insidePixels(facts: VolumeFacts, o: Orientation, map: SliceMap): number[] {
  const size = facts.levels[0]!.size;
  const ends = ([o.across, o.down] as const).map((axis, i) => {
    const at = (voxel: number): number => (voxel - map.first[i]!) / map.step[i]!;
    const [a, b] = [at(-0.5), at(size[axis] - 0.5)];
    const half = Math.max(0.5, Math.abs(b - a) / 2);
    return [(a + b) / 2 - half, (a + b) / 2 + half] as const;
  });
  return [ends[0]![0], ends[1]![0], ends[0]![1], ends[1]![1]];
}

export class SlicePainter {
  private readonly cover: Cover;

  constructor(private readonly gl: Gl) {
    this.cover = new Cover(gl, SHADER);
  }

  newTextures(): SliceTextures {
    const gl = this.gl;
    return {
      base: new PlaneTexture(gl),
      fine: new PlaneTexture(gl),
      colors: new PlaneTexture(gl),
    };
  }

  /** Draws one slice into a viewport of a canvas of `canvasHeight` device pixels. */
  draw(drawing: SliceDrawing, viewport: Viewport, canvasHeight: number): void {
    const gl = this.gl;
    const { facts, orientation: o, map, textures: t, window } = drawing;
    const bottom = canvasHeight - viewport.y - viewport.height;
    gl.viewport(viewport.x, bottom, viewport.width, viewport.height);
    gl.scissor(viewport.x, bottom, viewport.width, viewport.height);
    const c = this.cover;
    c.use();
    c.texture("base", 0, gl.TEXTURE_2D, t.base.handle);
    c.texture("fine", 1, gl.TEXTURE_2D, t.fine.handle);
    c.texture("colors", 2, gl.TEXTURE_2D, t.colors.handle);
    c.floats("baseMap", ...sampleMap(facts, o, t.base.level, map));
    c.floats("fineMap", ...sampleMap(facts, o, t.fine.level, map));
    c.floats("baseRect", ...t.base.rect);
    c.floats("fineRect", ...t.fine.rect);
    c.floats("corner", viewport.x, canvasHeight - viewport.y);
    c.floats("inside", ...insidePixels(facts, o, map));
    // Half of the powers of the width each, so that neither leaves what floats hold.
    const unit = powerOfTwo(Math.sqrt(window.width));
    c.floats("window", (window.center - window.width / 2) / unit, unit / window.width);
    const slope = (facts.slope * textureUnit(facts)) / unit;
    c.floats("real", slope, facts.intercept / unit);
    c.ints("isLabels", drawing.isLabels ? 1 : 0);
    c.ints("hasColors", drawing.colors ? 1 : 0);
    if (drawing.colors) {
      const from = drawing.colors;
      c.floats("colorMap", ...sampleMap(from.facts, from.orientation, t.colors.level, from.map));
      c.floats("colorRect", ...t.colors.rect);
      c.floats("colorShare", from.share);
    }
    c.draw();
  }
}

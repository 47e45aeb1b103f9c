// The shader of the 3-D view: rays through pages of several levels, of grey values, of labels, or
// of both. For each of the two, called NAME here, it is given
//
//     NAMETable   one texel per page of the finest level: its slot in the atlas, and 1 + the
//                 level's place in the ratios; 0 where nothing is seen or nothing is here
//     NAMERatio   samples of the finest level that one sample of a level spans, along each axis
//     NAMEReach   smallest and largest value of a page, its border counted in
//
// Positions are in samples of the finest level, whose sample i covers i .. i + 1: of the grey
// values, or of the labels where there are no grey values.
import { SLOT_SIDE, PAGE_SIDE } from "./atlas.js";
import { LABEL_COLORS_SIDE } from "./label_index.js";

export type Sampler = "" | "i" | "u";

/** Colors of grey values. */
export const GREY_COLORS = 1024;

/** grey: the sampler of its atlas, undefined for labels alone. */
export function rayShader(grey: Sampler | undefined, hasLabels: boolean): string {
  return `#version 300 es
precision highp float;
precision highp int;
precision highp sampler3D;
precision highp isampler3D;
precision highp usampler3D;
uniform vec3 lo, hi;             // the box that rays cross
uniform vec3 middle, right, down, forward;  // of the picture; forward for one mm
uniform vec2 picture;            // its size in pixels
uniform float reachMm, stepMm;
uniform int mode;                // 0 iso, 1 maximum, 2 volume
uniform vec3 light;
out vec4 color;

const float NOTHING = -3.0e38;

struct Place { uvec4 entry; vec3 scale; };

float brightness(vec3 slope) {
  vec3 sizes = abs(slope);
  float largest = max(sizes.x, max(sizes.y, sizes.z));
  if (largest < 1e-20) return 0.8;
  // Squares of steep slopes would be infinite.
  return 0.28 + 0.72 * abs(dot(normalize(slope / largest), light));
}

// How far a ray may go until it leaves the page that it is in.
float exitOf(vec3 at, vec3 step) {
  vec3 page = floor(at / ${PAGE_SIDE}.0);
  vec3 face = (page + vec3(greaterThan(step, vec3(0.0)))) * ${PAGE_SIDE}.0;
  vec3 far = (face - at) / step;
  far = mix(far, vec3(1e30), vec3(lessThan(abs(step), vec3(1e-9))));
  return max(min(far.x, min(far.y, far.z)), 0.0);
}

float noise(vec2 p) {
  return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715))));
}
${grey === undefined ? "" : pagesOf("grey", grey) + GREY_FUNCTIONS}
${hasLabels ? pagesOf("label", "u") + LABEL_FUNCTIONS : ""}
void main() {
  vec2 pixel = vec2(gl_FragCoord.x, picture.y - gl_FragCoord.y) - picture * 0.5;
  vec3 start = middle + right * pixel.x + down * pixel.y - forward * reachMm;
  vec3 low = (lo - start) / forward, high = (hi - start) / forward;
  vec3 nearest = min(low, high), farthest = max(low, high);
  for (int a = 0; a < 3; ++a) {
    if (abs(forward[a]) > 1e-9) continue;
    bool isIn = start[a] >= lo[a] && start[a] <= hi[a];
    nearest[a] = isIn ? -1e30 : 1e30;
    farthest[a] = isIn ? 1e30 : -1e30;
  }
  float t = max(max(nearest.x, nearest.y), max(nearest.z, 0.0));
  float end = min(farthest.x, min(farthest.y, farthest.z));
  color = vec4(0.0);
  if (t >= end) return;
  float first = t;
  t += stepMm * noise(gl_FragCoord.xy);
  float most = NOTHING, before = NOTHING, beforeT = t, beforeLabel = 0.0;
  vec3 sum = vec3(0.0);
  float through = 1.0;
  for (int i = 0; i < 6000 && t < end; ++i) {
    vec3 at = start + forward * t;
    float empty = 1e30;  // how far nothing is seen
    ${grey === undefined ? "" : GREY_PLACE}
    ${hasLabels ? LABEL_PLACE : ""}
    if (empty > 0.0) {
      t += empty + stepMm * 0.5;
      before = NOTHING;
      beforeLabel = 0.0;
      continue;
    }
    ${hasLabels ? LABELS : ""}
    ${grey === undefined ? "" : GREY}
    t += stepMm;
  }
  ${grey === undefined ? "" : MAXIMUM}
  color = vec4(sum, 1.0 - through);
}`;
}

/** Uniforms and functions of the pages of one volume. */
function pagesOf(name: string, sampler: Sampler): string {
  return `
uniform ${sampler}sampler3D ${name}Atlas;
uniform usampler3D ${name}Table;
uniform sampler3D ${name}Reach;
uniform vec3 ${name}Ratio[16];
uniform ivec3 ${name}Grid;
uniform vec3 ${name}Mm;                                  // one sample, mm
uniform vec3 ${name}ToMm0, ${name}ToMm1, ${name}ToMm2;   // rows of the matrix to mm, for light

ivec3 ${name}Page(vec3 at) { return ivec3(floor(at / ${PAGE_SIDE}.0)); }

Place ${name}Place(vec3 at) {
  ivec3 page = ${name}Page(at);
  if (any(lessThan(page, ivec3(0))) || any(greaterThanEqual(page, ${name}Grid)))
    return Place(uvec4(0u), vec3(1.0));
  uvec4 entry = texelFetch(${name}Table, page, 0);
  return Place(entry, entry.a == 0u ? vec3(1.0) : ${name}Ratio[int(entry.a) - 1]);
}

ivec3 ${name}Corner(Place place, vec3 sampleAt, out vec3 local) {
  local = sampleAt - floor(sampleAt / ${PAGE_SIDE}.0) * ${PAGE_SIDE}.0;
  return ivec3(place.entry.xyz) * ${SLOT_SIDE} + 1;
}

float ${name}Texel(ivec3 at) { return float(texelFetch(${name}Atlas, at, 0).r); }

vec3 ${name}Slope(vec3 g) {
  g /= ${name}Mm;
  return vec3(dot(${name}ToMm0, g), dot(${name}ToMm1, g), dot(${name}ToMm2, g));
}
`;
}

const GREY_FUNCTIONS = `
uniform sampler2D greyColors;
uniform float layerMm, iso;
uniform vec2 real;               // slope, intercept; values are in the unit of the pages
uniform vec2 window;             // black, and 1 / width
uniform vec2 span;               // values of the colors: first, and 1 / length
uniform float lowest;            // stored value: what is below counts as it
uniform float nothing;           // stored value: what is below is empty space

float greyIn(ivec3 at) { return max(greyTexel(at), lowest); }

// The stored value at a position, interpolated within the page that the position lies in.
float valueIn(Place place, vec3 at) {
  vec3 local;
  ivec3 corner = greyCorner(place, at / place.scale, local);
  local = clamp(local - 0.5, vec3(-1.0), vec3(${PAGE_SIDE}.0 - 0.001));
  ivec3 low = ivec3(floor(local));
  vec3 share = local - vec3(low);
  ivec3 c = corner + low;
  float a = mix(greyIn(c), greyIn(c + ivec3(1, 0, 0)), share.x);
  float b = mix(greyIn(c + ivec3(0, 1, 0)), greyIn(c + ivec3(1, 1, 0)), share.x);
  float d = mix(greyIn(c + ivec3(0, 0, 1)), greyIn(c + ivec3(1, 0, 1)), share.x);
  float e = mix(greyIn(c + ivec3(0, 1, 1)), greyIn(c + ivec3(1, 1, 1)), share.x);
  return mix(mix(a, b, share.y), mix(d, e, share.y), share.z);
}

float valueAt(vec3 at, float otherwise) {
  Place place = greyPlace(at);
  return place.entry.a == 0u ? otherwise : valueIn(place, at);
}

// Towards higher values, in mm.
vec3 slopeAt(vec3 at, vec3 h, float here) {
  vec3 g = vec3(valueAt(at + vec3(h.x, 0, 0), here) - valueAt(at - vec3(h.x, 0, 0), here),
                valueAt(at + vec3(0, h.y, 0), here) - valueAt(at - vec3(0, h.y, 0), here),
                valueAt(at + vec3(0, 0, h.z), here) - valueAt(at - vec3(0, 0, h.z), here));
  return greySlope(g / h);
}
`;

const LABEL_FUNCTIONS = `
uniform sampler2D labelColors;   // of the numbers of labels, row by row
uniform float labelShare;
uniform vec3 labelX, labelY, labelZ, labelFrom;  // from positions to those of labels

float labelAt(vec3 at) {
  Place place = labelPlace(at);
  if (place.entry.a == 0u) return 0.0;
  vec3 local;
  ivec3 corner = labelCorner(place, at / place.scale, local);
  return labelTexel(corner + ivec3(floor(local)));
}

vec4 colorOfLabel(float label) {
  int number = int(label);
  return texelFetch(labelColors,
                    ivec2(number % ${LABEL_COLORS_SIDE}, number / ${LABEL_COLORS_SIDE}), 0);
}

vec3 toLabels(vec3 v) { return labelX * v.x + labelY * v.y + labelZ * v.z; }
`;

const GREY_PLACE = `Place place = greyPlace(at);
    bool hasGrey = place.entry.a != 0u;
    if (hasGrey && mode == 1) {
      vec2 ends = texelFetch(greyReach, greyPage(at), 0).rg * real.x + real.y;
      hasGrey = max(ends.x, ends.y) > most;
    }
    empty = hasGrey ? 0.0 : min(empty, exitOf(at, forward));`;

const LABEL_PLACE = `vec3 labelPosition = toLabels(at) + labelFrom;
    Place labels = labelPlace(labelPosition);
    bool hasLabel = labels.entry.a != 0u;
    empty = hasLabel ? 0.0 : min(empty, exitOf(labelPosition, toLabels(forward)));`;

const GREY = `
    if (!hasGrey) {
      before = NOTHING;
      t += stepMm;
      continue;
    }
    float stored = valueIn(place, at);
    float value = stored * real.x + real.y;
    if (mode == 1) {
      most = max(most, value);
    } else if (mode == 0) {
      if (value >= iso) {
        float a = before > NOTHING ? beforeT : t - stepMm, b = t;
        for (int k = 0; k < 5; ++k) {
          float c = 0.5 * (a + b);
          vec3 between = start + forward * c;
          if (valueAt(between, NOTHING) * real.x + real.y >= iso) b = c; else a = c;
        }
        vec3 hit = start + forward * max(b, first);
        float here = valueAt(hit, stored);
        vec3 slope = slopeAt(hit, place.scale, here) * real.x;
        vec3 bone = vec3(0.93, 0.89, 0.80);
        float depth = 1.0 - 0.35 * clamp((t - first) / (end - first + 1e-6), 0.0, 1.0);
        sum += through * bone * brightness(slope) * depth;
        through = 0.0;
        break;
      }
      before = value;
      beforeT = t;
    } else {
      float share = clamp((value - span.x) * span.y, 0.0, 1.0);
      vec4 look = texelFetch(greyColors, ivec2(int(share * ${GREY_COLORS - 1}.0 + 0.5), 0), 0);
      if (stored < nothing) look.a = 0.0;
      float alpha = 1.0 - pow(1.0 - min(look.a, 0.9999), stepMm / layerMm);
      if (alpha > 0.002) {
        vec3 slope = slopeAt(at, place.scale, stored) * real.x;
        sum += through * alpha * look.rgb * brightness(slope);
        through *= 1.0 - alpha;
        if (through < 0.02) { through = 0.0; break; }
      }
    }`;

// A label is seen where a ray enters it.
const LABELS = `
    float label = hasLabel ? labelAt(labelPosition) : 0.0;
    if (label > 0.5 && label != beforeLabel) {
      vec4 look = colorOfLabel(label);
      float alpha = look.a * labelShare;
      if (alpha > 0.0) {
        // Where it is entered, so that neighbors are lit alike.
        float a = max(first, t - stepMm), b = t;
        for (int k = 0; k < 4; ++k) {
          float c = 0.5 * (a + b);
          if (labelAt(toLabels(start + forward * c) + labelFrom) == label) b = c; else a = c;
        }
        vec3 entry = toLabels(start + forward * b) + labelFrom;
        vec3 h = labels.scale;
        vec3 g = vec3(0.0);
        for (int n = 0; n < 3; ++n) {
          vec3 s = vec3(n == 0 ? h.x : 0.0, n == 1 ? h.y : 0.0, n == 2 ? h.z : 0.0);
          for (int k = 1; k <= 2; ++k) {
            g[n] += float(labelAt(entry + s * float(k)) == label) -
                    float(labelAt(entry - s * float(k)) == label);
          }
        }
        sum += through * alpha * look.rgb * brightness(labelSlope(g / h));
        through *= 1.0 - alpha;
        if (through < 0.02) { through = 0.0; break; }
      }
    }
    beforeLabel = label;`;

const MAXIMUM = `if (mode == 1 && most > NOTHING) {
    float grey = clamp((most - window.x) * window.y, 0.0, 1.0);
    color = vec4(sum + through * vec3(grey), 1.0);
    return;
  }`;

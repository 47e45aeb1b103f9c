// The shader of the 3-D view: rays through pages of several levels.
//
//     table    one texel per page of the finest level: its slot in the atlas, and 1 + the level's
//              place in `ratio`; 0 where nothing is seen or nothing is here
//     ratio    samples of the finest level that one sample of that level spans, along each axis
//     reach    smallest and largest value of a page, its border counted in
//
// Positions are in samples of the finest level, whose sample i covers i .. i + 1.
import { SLOT_SIDE, PAGE_SIDE } from "./atlas.js";

export function rayShader(sampler: "" | "i" | "u", isLabels: boolean): string {
  return `#version 300 es
precision highp float;
precision highp int;
precision highp ${sampler}sampler3D;
precision highp usampler3D;
precision highp sampler3D;
uniform ${sampler}sampler3D atlas;
uniform usampler3D table;
uniform sampler3D reach;
uniform sampler2D palette;
uniform vec3 ratio[16];
uniform ivec3 grid;
uniform vec3 lo, hi;             // the box that rays cross
uniform vec3 middle, right, down, forward;  // of the picture; forward for one mm
uniform vec3 mm;                 // one sample, mm
uniform vec2 picture;            // its size in pixels
uniform vec3 toMm0, toMm1, toMm2;  // rows of the matrix from samples to mm, for light
uniform float reachMm, stepMm, layerMm;
uniform vec2 real;
uniform int mode;                // 0 iso, 1 maximum, 2 volume
uniform float iso;
uniform vec2 window;             // black, and 1 / width
uniform vec2 span;               // values of the palette: first, and 1 / length
uniform vec3 light;
out vec4 color;

const float NOTHING = -3.0e38;

struct Place { uvec4 entry; vec3 scale; };

Place placeOf(vec3 at) {
  ivec3 page = clamp(ivec3(floor(at / ${PAGE_SIDE}.0)), ivec3(0), grid - 1);
  uvec4 entry = texelFetch(table, page, 0);
  return Place(entry, entry.a == 0u ? vec3(1.0) : ratio[int(entry.a) - 1]);
}

ivec3 slotCorner(Place place, vec3 sampleAt, out vec3 local) {
  vec3 page = floor(sampleAt / ${PAGE_SIDE}.0);
  local = sampleAt - page * ${PAGE_SIDE}.0;
  return ivec3(place.entry.xyz) * ${SLOT_SIDE} + 1;
}

float texel(ivec3 at) { return float(texelFetch(atlas, at, 0).r); }

// The stored value at a position, interpolated within the page that the position lies in.
float valueIn(Place place, vec3 at) {
  vec3 local;
  ivec3 corner = slotCorner(place, at / place.scale, local);
  local = clamp(local - 0.5, vec3(-1.0), vec3(${PAGE_SIDE}.0 - 0.001));
  ivec3 low = ivec3(floor(local));
  vec3 share = local - vec3(low);
  ivec3 c = corner + low;
  float a = mix(texel(c), texel(c + ivec3(1, 0, 0)), share.x);
  float b = mix(texel(c + ivec3(0, 1, 0)), texel(c + ivec3(1, 1, 0)), share.x);
  float d = mix(texel(c + ivec3(0, 0, 1)), texel(c + ivec3(1, 0, 1)), share.x);
  float e = mix(texel(c + ivec3(0, 1, 1)), texel(c + ivec3(1, 1, 1)), share.x);
  return mix(mix(a, b, share.y), mix(d, e, share.y), share.z);
}

float valueAt(vec3 at, float otherwise) {
  Place place = placeOf(at);
  return place.entry.a == 0u ? otherwise : valueIn(place, at);
}

float labelAt(vec3 at) {
  Place place = placeOf(at);
  if (place.entry.a == 0u) return 0.0;
  vec3 local;
  ivec3 corner = slotCorner(place, at / place.scale, local);
  return texel(corner + ivec3(floor(local)));
}

vec4 colorOfLabel(float label) {
  return texelFetch(palette, ivec2(int(mod(label, 1024.0)), 0), 0);
}

// Towards higher values, in mm.
vec3 slopeAt(vec3 at, vec3 h, float here) {
  vec3 g = vec3(valueAt(at + vec3(h.x, 0, 0), here) - valueAt(at - vec3(h.x, 0, 0), here),
                valueAt(at + vec3(0, h.y, 0), here) - valueAt(at - vec3(0, h.y, 0), here),
                valueAt(at + vec3(0, 0, h.z), here) - valueAt(at - vec3(0, 0, h.z), here));
  g /= h * mm;
  return vec3(dot(toMm0, g), dot(toMm1, g), dot(toMm2, g));
}

float brightness(vec3 slope) {
  float size = length(slope);
  if (size < 1e-20) return 0.8;
  return 0.28 + 0.72 * abs(dot(slope / size, light));
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
  float most = NOTHING, before = NOTHING, beforeT = t;
  vec3 sum = vec3(0.0);
  float through = 1.0;
  for (int i = 0; i < 6000 && t < end; ++i) {
    vec3 at = start + forward * t;
    Place place = placeOf(at);
    bool isEmpty = place.entry.a == 0u;
    if (!isEmpty && mode == 1) {
      ivec3 page = clamp(ivec3(floor(at / ${PAGE_SIDE}.0)), ivec3(0), grid - 1);
      vec2 ends = texelFetch(reach, page, 0).rg * real.x + real.y;
      isEmpty = max(ends.x, ends.y) <= most;
    }
    if (isEmpty) {
      t += max(exitOf(at, forward), 0.0) + stepMm * 0.5;
      before = NOTHING;
      continue;
    }
    ${isLabels ? LABELS : GREY}
    t += stepMm;
  }
  if (mode == 1 && most > NOTHING) {
    float grey = clamp((most - window.x) * window.y, 0.0, 1.0);
    color = vec4(vec3(grey), 1.0);
    return;
  }
  color = vec4(sum, 1.0 - through);
}`;
}

const GREY = `
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
        sum = bone * brightness(slope) * depth;
        through = 0.0;
        break;
      }
      before = value;
      beforeT = t;
    } else {
      float share = clamp((value - span.x) * span.y, 0.0, 1.0);
      vec4 look = texelFetch(palette, ivec2(int(share * 1023.0 + 0.5), 0), 0);
      float alpha = 1.0 - pow(1.0 - min(look.a, 0.9999), stepMm / layerMm);
      if (alpha > 0.002) {
        vec3 slope = slopeAt(at, place.scale, stored) * real.x;
        sum += through * alpha * look.rgb * brightness(slope);
        through *= 1.0 - alpha;
        if (through < 0.02) { through = 0.0; break; }
      }
    }`;

const LABELS = `
    float label = labelAt(at);
    vec4 look = colorOfLabel(label);
    if (label > 0.5 && look.a > 0.0) {
      vec3 h = place.scale;
      vec3 g = vec3(0.0);
      for (int a = 0; a < 3; ++a) {
        vec3 s = vec3(a == 0 ? h.x : 0.0, a == 1 ? h.y : 0.0, a == 2 ? h.z : 0.0);
        for (int k = 1; k <= 2; ++k) {
          g[a] += float(labelAt(at + s * float(k)) == label) -
                  float(labelAt(at - s * float(k)) == label);
        }
      }
      g /= h * mm;
      vec3 slope = vec3(dot(toMm0, g), dot(toMm1, g), dot(toMm2, g));
      if (label != before) {
        sum += through * look.a * look.rgb * brightness(slope);
        through *= 1.0 - look.a;
        if (through < 0.02) { through = 0.0; break; }
      }
    }
    before = label;`;

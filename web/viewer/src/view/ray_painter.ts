// The 3-D view on the screen: rays through the pages of one or two volumes, into a picture that is
// kept.
//
// While something moves the picture is drawn small; once it rests it is drawn again in full, in
// bands, so that nothing else has to wait.
import { AXES, type Box, type Vec3 } from "../reader/volume.js";
import { LOWEST_FLOAT, nanWithin } from "./atlas.js";
import { type Camera, dot, plus, raysOf, viewAxes } from "./camera.js";
import { toIndex, toWorld } from "./geometry.js";
import { Cover, type Gl, nearestTexture, texelFormat } from "./gl.js";
import { LABEL_COLORS_SIDE } from "./label_index.js";
import { type PageAtlas } from "./page_atlas.js";
import { GREY_COLORS, rayShader } from "./ray_shader.js";
import { type Viewport } from "./slice_painter.js";

export interface RayLook {
  readonly mode: "iso" | "mip" | "volume";
  readonly iso: number;
  readonly window: { readonly center: number; readonly width: number };
  /** GREY_COLORS colors of four bytes over `span` of values. */
  readonly greyColors: Uint8Array;
  readonly span: readonly [number, number];
  readonly layerMm: number;
  /** Colors of the numbers of labels, and how much of what is behind them they cover. */
  readonly labelColors: Uint8Array;
  readonly labelShare: number;
  /** Voxels of level 0. */
  readonly clip: Box;
}

/** What is drawn: grey values, labels, or labels over grey values. */
export interface RayVolumes {
  readonly grey: PageAtlas | undefined;
  readonly labels: PageAtlas | undefined;
}

const SHOW = `#version 300 es
precision highp float;
uniform sampler2D picture;
uniform vec4 place;  // corner, 1 / size
uniform vec3 behind;
out vec4 color;
void main() {
  vec4 seen = texture(picture, (gl_FragCoord.xy - place.xy) * place.zw);
  color = vec4(seen.rgb + behind * (1.0 - seen.a), 1.0);
}`;

interface Target {
  readonly frame: WebGLFramebuffer;
  readonly texture: WebGLTexture;
  width: number;
  height: number;
}

function newTarget(gl: Gl): Target {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  return { frame: gl.createFramebuffer(), texture, width: 0, height: 0 };
}

function resize(gl: Gl, target: Target, width: number, height: number): void {
  if (target.width === width && target.height === height) return;
  gl.bindTexture(gl.TEXTURE_2D, target.texture);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
  gl.bindFramebuffer(gl.FRAMEBUFFER, target.frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target.texture, 0);
  target.width = width;
  target.height = height;
}

const BANDS = 8;

/** A texture of colors that is written anew where they are others. */
class Colors {
  private readonly texture: WebGLTexture;
  private shown: Uint8Array | undefined;

  constructor(
    private readonly gl: Gl,
    private readonly width: number,
    private readonly height: number,
  ) {
    this.texture = nearestTexture(gl, gl.TEXTURE_2D);
  }

  bind(cover: Cover, name: string, unit: number, colors: Uint8Array): void {
    const { gl, width: w, height: h } = this;
    cover.texture(name, unit, gl.TEXTURE_2D, this.texture);
    if (this.shown === colors) return;
    this.shown = colors;
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, w, h, 0, gl.RGBA, gl.UNSIGNED_BYTE, colors);
  }

  dispose(): void {
    this.gl.deleteTexture(this.texture);
  }
}

type Numbers = [number, number, number];

export class RayPainter {
  private readonly rays: Cover;
  private readonly show: Cover;
  private readonly greyColors: Colors;
  private readonly labelColors: Colors;
  private readonly targets: [Target, Target];
  private shown: Target | undefined;
  private readonly main: PageAtlas;

  /** There is one volume, or both; labels alone are drawn as such. */
  constructor(
    private readonly gl: Gl,
    private readonly volumes: RayVolumes,
  ) {
    const { grey, labels } = volumes;
    this.main = (grey ?? labels)!;
    const sampler = grey && texelFormat(gl, grey.facts.type).sampler;
    this.rays = new Cover(gl, rayShader(sampler, labels !== undefined));
    this.show = new Cover(gl, SHOW);
    this.greyColors = new Colors(gl, GREY_COLORS, 1);
    this.labelColors = new Colors(gl, LABEL_COLORS_SIDE, LABEL_COLORS_SIDE);
    this.targets = [newTarget(gl), newTarget(gl)];
  }

  /** Sets all that the shader needs for a picture of so many pixels. */
  private aim(
    camera: Camera,
    look: RayLook,
    width: number,
    height: number,
    quality: number,
  ): void {
    const { rays: c, main } = this;
    const { grey, labels } = this.volumes;
    const { facts, factor: f } = main;
    const g = facts.geometry;
    const rays = raysOf(g, facts.levels[0]!.size, camera, width, height);
    const scaled = (v: Vec3): Numbers => [v[0] / f[0], v[1] / f[1], v[2] / f[2]];
    c.use();
    c.floats("lo", ...scaled(look.clip.lo));
    c.floats("hi", ...scaled(look.clip.hi));
    // Centers of voxels are whole numbers there, and halves here.
    c.floats("middle", ...scaled(rays.middle.map((v) => v + 0.5) as unknown as Vec3));
    c.floats("right", ...scaled(rays.right));
    c.floats("down", ...scaled(rays.down));
    c.floats("forward", ...scaled(rays.forward));
    c.floats("picture", width, height);
    c.floats("reachMm", rays.reachMm);
    c.floats("stepMm", Math.min(...AXES.map((a) => g.spacing[a] * f[a])) / quality);
    c.floats("light", ...lightOf(camera));
    c.ints("mode", { iso: 0, mip: 1, volume: 2 }[look.mode]);
    if (grey) this.aimGrey(grey, look);
    if (labels) this.aimLabels(labels, look);
  }

  private aimGrey(grey: PageAtlas, look: RayLook): void {
    const c = this.rays;
    const { facts, unit } = grey;
    const { center, width } = look.window;
    const [first, last] = look.span.map((value) => value / unit) as [number, number];
    this.aimPages(grey, "grey", 0);
    this.greyColors.bind(c, "greyColors", 3, look.greyColors);
    c.floats("layerMm", look.layerMm);
    c.floats("real", facts.slope, facts.intercept / unit);
    c.floats("iso", look.iso / unit);
    c.floats("window", (center - width / 2) / unit, unit / width);
    c.floats("span", first, 1 / Math.max(1e-30, last - first));
    // NaN is empty space to one mode, the lowest value to others; what interpolation takes a
    // thousandth of the way to it as well.
    const [lowest] = facts.range;
    const isSpace = look.mode === "volume" && facts.type === "float32";
    c.floats("lowest", isSpace ? LOWEST_FLOAT : lowest / unit);
    const nothing = lowest + (nanWithin(facts.range) - lowest) / 1024;
    c.floats("nothing", isSpace ? nothing / unit : LOWEST_FLOAT);
  }

  private aimLabels(labels: PageAtlas, look: RayLook): void {
    const c = this.rays;
    this.aimPages(labels, "label", 4);
    this.labelColors.bind(c, "labelColors", 7, look.labelColors);
    c.floats("labelShare", look.labelShare);
    const zero = labelPosition(this.main, labels, [0, 0, 0]);
    c.floats("labelFrom", ...(zero as Numbers));
    for (const a of AXES) {
      const one = AXES.map((b) => (a === b ? 1 : 0)) as unknown as Vec3;
      const step = plus(labelPosition(this.main, labels, one), zero, -1);
      c.floats(["labelX", "labelY", "labelZ"][a]!, ...(step as Numbers));
    }
  }

  private aimPages(atlas: PageAtlas, name: string, unit: number): void {
    const c = this.rays;
    const { geometry: g } = atlas.facts;
    const f = atlas.factor;
    atlas.bind(c, name, unit);
    c.floats(`${name}Mm`, ...(AXES.map((a) => g.spacing[a] * f[a]) as Numbers));
    for (const r of AXES) {
      c.floats(`${name}ToMm${r}`, ...(AXES.map((a) => g.direction[3 * r + a]!) as Numbers));
    }
  }

  /** Draws band `band` of BANDS into the picture that is not shown; all of it where `band` is
   *  undefined. The picture is shown once it is whole. */
  trace(
    camera: Camera,
    look: RayLook,
    width: number,
    height: number,
    quality: number,
    band?: number,
  ): boolean {
    if (!this.main.hasTable || this.volumes.labels?.hasTable === false) return false;
    const gl = this.gl;
    const target = this.targets[this.shown === this.targets[0] ? 1 : 0];
    resize(gl, target, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.frame);
    const from = band === undefined ? 0 : Math.floor((height * band) / BANDS);
    const to = band === undefined ? height : Math.floor((height * (band + 1)) / BANDS);
    gl.viewport(0, 0, width, height);
    gl.scissor(0, from, width, to - from);
    this.aim(camera, look, width, height, quality);
    this.rays.draw();
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const isWhole = band === undefined || band === BANDS - 1;
    if (isWhole) this.shown = target;
    return isWhole;
  }

  /** Puts the picture that is there on the screen. */
  draw(viewport: Viewport, canvasHeight: number, behind: Vec3): void {
    if (!this.shown) return;
    const gl = this.gl;
    const bottom = canvasHeight - viewport.y - viewport.height;
    gl.viewport(viewport.x, bottom, viewport.width, viewport.height);
    gl.scissor(viewport.x, bottom, viewport.width, viewport.height);
    this.show.use();
    this.show.texture("picture", 0, gl.TEXTURE_2D, this.shown.texture);
    this.show.floats("place", viewport.x, bottom, 1 / viewport.width, 1 / viewport.height);
    this.show.floats("behind", ...behind);
    this.show.draw();
  }

  get hasPicture(): boolean {
    return this.shown !== undefined;
  }

  /** Gives back what the graphics card keeps for it. The atlases are others'. */
  dispose(): void {
    for (const held of [this.rays, this.show, this.greyColors, this.labelColors]) held.dispose();
    for (const { frame, texture } of this.targets) {
      this.gl.deleteFramebuffer(frame);
      this.gl.deleteTexture(texture);
    }
  }
}

/** Where a position among samples of one volume lies among those of labels. */
function labelPosition(main: PageAtlas, labels: PageAtlas, at: Vec3): Vec3 {
  if (main === labels) return at;
  const [f, of] = [main.factor, labels.factor];
  const voxel = AXES.map((a) => at[a] * f[a] - 0.5) as unknown as Vec3;
  const found = toIndex(labels.facts.geometry, toWorld(main.facts.geometry, voxel));
  return AXES.map((a) => (found[a] + 0.5) / of[a]) as unknown as Vec3;
}

export const BAND_COUNT = BANDS;

/** A lamp above the viewer's left shoulder. */
function lightOf(camera: Camera): Vec3 {
  const axes = viewAxes(camera);
  const lamp = AXES.map(
    (a) => axes.toward[a] + 0.35 * axes.up[a] - 0.3 * axes.right[a],
  ) as unknown as Vec3;
  const length = Math.sqrt(dot(lamp, lamp));
  return lamp.map((v) => v / length) as unknown as Vec3;
}

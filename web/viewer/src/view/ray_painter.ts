// The 3-D view on the screen: an atlas of pages, its table, and rays into a picture that is kept.
//
// While something moves the picture is drawn small; once it rests it is drawn again in full, in
// bands, so that nothing else has to wait.
import { AXES, type Box, type Vec3, type VolumeFacts } from "../reader/volume.js";
import { SLOT_SIDE, type PageVoxels } from "./atlas.js";
import { type Camera, dot, raysOf, viewAxes } from "./camera.js";
import { Cover, type Gl, type TexelFormat, nearestTexture, texelFormat } from "./gl.js";
import { rayShader } from "./ray_shader.js";
import { type Viewport } from "./slice_painter.js";

export interface RayLook {
  readonly mode: "iso" | "mip" | "volume";
  readonly iso: number;
  readonly window: { readonly center: number; readonly width: number };
  /** 1024 colors of four bytes: over `span` of values, or of labels modulo 1024. */
  readonly palette: Uint8Array;
  readonly span: readonly [number, number];
  readonly layerMm: number;
  /** Voxels of level 0. */
  readonly clip: Box;
}

export interface RayTable {
  readonly level: number;
  readonly grid: Vec3;
  readonly entries: Uint8Array;
  readonly reach: Float32Array;
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

export class RayPainter {
  private readonly rays: Cover;
  private readonly show: Cover;
  private readonly format: TexelFormat;
  private readonly atlas: WebGLTexture;
  private readonly entries: WebGLTexture;
  private readonly reach: WebGLTexture;
  private readonly palette: WebGLTexture;
  private readonly targets: [Target, Target];
  private shown: Target | undefined;
  private table: RayTable | undefined;
  private shownPalette: Uint8Array | undefined;

  constructor(
    private readonly gl: Gl,
    private readonly facts: VolumeFacts,
    shape: Vec3,
    private readonly coarsest: number,
  ) {
    this.format = texelFormat(gl, facts.type);
    this.rays = new Cover(gl, rayShader(this.format.sampler, facts.kind === "labels"));
    this.show = new Cover(gl, SHOW);
    this.atlas = nearestTexture(gl, gl.TEXTURE_3D);
    const [x, y, z] = shape;
    gl.texStorage3D(
      gl.TEXTURE_3D,
      1,
      this.format.internal,
      x * SLOT_SIDE,
      y * SLOT_SIDE,
      z * SLOT_SIDE,
    );
    this.entries = nearestTexture(gl, gl.TEXTURE_3D);
    this.reach = nearestTexture(gl, gl.TEXTURE_3D);
    this.palette = nearestTexture(gl, gl.TEXTURE_2D);
    this.targets = [newTarget(gl), newTarget(gl)];
  }

  upload(slot: Vec3, page: PageVoxels): void {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_3D, this.atlas);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texSubImage3D(
      gl.TEXTURE_3D,
      0,
      slot[0] * SLOT_SIDE,
      slot[1] * SLOT_SIDE,
      slot[2] * SLOT_SIDE,
      SLOT_SIDE,
      SLOT_SIDE,
      SLOT_SIDE,
      this.format.format,
      this.format.type,
      page.voxels as ArrayBufferView,
    );
  }

  setTable(table: RayTable): void {
    const gl = this.gl;
    const [x, y, z] = table.grid;
    this.table = table;
    gl.activeTexture(gl.TEXTURE0);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.bindTexture(gl.TEXTURE_3D, this.entries);
    gl.texImage3D(
      gl.TEXTURE_3D,
      0,
      gl.RGBA8UI,
      x,
      y,
      z,
      0,
      gl.RGBA_INTEGER,
      gl.UNSIGNED_BYTE,
      table.entries,
    );
    gl.bindTexture(gl.TEXTURE_3D, this.reach);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RG32F, x, y, z, 0, gl.RG, gl.FLOAT, table.reach);
  }

  private putPalette(palette: Uint8Array): void {
    if (palette === this.shownPalette) return;
    this.shownPalette = palette;
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.palette);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 1024, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, palette);
  }

  /** Sets all that the shader needs for a picture of so many pixels. */
  private aim(
    camera: Camera,
    look: RayLook,
    width: number,
    height: number,
    quality: number,
  ): void {
    const gl = this.gl;
    const { facts, rays: c } = this;
    const table = this.table!;
    const g = facts.geometry;
    const f = facts.levels[table.level]!.factor;
    const rays = raysOf(g, facts.levels[0]!.size, camera, width, height);
    const scaled = (v: Vec3): [number, number, number] => [v[0] / f[0], v[1] / f[1], v[2] / f[2]];
    // Centers of voxels are whole numbers there, and halves here.
    const middle = scaled(rays.middle.map((v) => v + 0.5) as unknown as Vec3);
    const mm = AXES.map((a) => g.spacing[a] * f[a]) as unknown as [number, number, number];
    c.use();
    c.texture("atlas", 0, gl.TEXTURE_3D, this.atlas);
    c.texture("table", 1, gl.TEXTURE_3D, this.entries);
    c.texture("reach", 2, gl.TEXTURE_3D, this.reach);
    c.texture("palette", 3, gl.TEXTURE_2D, this.palette);
    const ratio = new Float32Array(48).fill(1);
    for (let k = table.level; k <= this.coarsest && k - table.level < 16; ++k) {
      AXES.forEach((a) => {
        ratio[3 * (k - table.level) + a] = facts.levels[k]!.factor[a] / f[a];
      });
    }
    c.vectors("ratio", ratio);
    c.ints("grid", ...table.grid);
    c.floats("lo", ...scaled(look.clip.lo));
    c.floats("hi", ...scaled(look.clip.hi));
    c.floats("middle", ...middle);
    c.floats("right", ...scaled(rays.right));
    c.floats("down", ...scaled(rays.down));
    c.floats("forward", ...scaled(rays.forward));
    c.floats("mm", ...mm);
    c.floats("picture", width, height);
    const d = g.direction as number[];
    c.floats("toMm0", d[0]!, d[1]!, d[2]!);
    c.floats("toMm1", d[3]!, d[4]!, d[5]!);
    c.floats("toMm2", d[6]!, d[7]!, d[8]!);
    c.floats("reachMm", rays.reachMm);
    c.floats("stepMm", Math.min(...mm) / quality);
    c.floats("layerMm", look.layerMm);
    c.floats("real", facts.slope, facts.intercept);
    c.ints("mode", { iso: 0, mip: 1, volume: 2 }[look.mode]);
    c.floats("iso", look.iso);
    c.floats("window", look.window.center - look.window.width / 2, 1 / look.window.width);
    c.floats("span", look.span[0], 1 / Math.max(1e-30, look.span[1] - look.span[0]));
    c.floats("light", ...lightOf(camera));
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
    if (!this.table) return false;
    const gl = this.gl;
    const target = this.targets[this.shown === this.targets[0] ? 1 : 0];
    resize(gl, target, width, height);
    this.putPalette(look.palette);
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

// The textures of one volume in 3-D: pages, the table that leads to them, and what they reach.
import { AXES, type Vec3, type VolumeFacts, type Voxels } from "../reader/volume.js";
import { SLOT_SIDE, type PageVoxels } from "./atlas.js";
import { type Cover, type Gl, type TexelFormat, nearestTexture, texelFormat } from "./gl.js";
import { type LabelIndex } from "./label_index.js";
import { powerOfTwo } from "./window.js";

export interface RayTable {
  readonly level: number;
  readonly grid: Vec3;
  readonly entries: Uint8Array;
  readonly reach: Float32Array;
}

/** Levels that one table can lead to. */
const MOST_LEVELS = 16;

/** Stored values; of labels their numbers in an index. */
export function atlasFormat(gl: Gl, facts: VolumeFacts): TexelFormat {
  return texelFormat(gl, facts.kind === "labels" ? "uint16" : facts.type);
}

/** What stored and real values are counted in on the graphics card: 1, but where squares of
 *  their differences, or parts of their range, could leave what 32-bit floats hold. */
export function unitOf(facts: VolumeFacts): number {
  if (facts.type !== "float32") return 1;
  const largest = Math.max(...facts.range.map(Math.abs));
  return largest > 1e9 || largest < 1e-6 ? powerOfTwo(largest) : 1;
}

export class PageAtlas {
  readonly unit: number;
  private readonly format: TexelFormat;
  private readonly pages: WebGLTexture;
  private readonly entries: WebGLTexture;
  private readonly reach: WebGLTexture;
  private table: RayTable | undefined;

  constructor(
    private readonly gl: Gl,
    readonly facts: VolumeFacts,
    shape: Vec3,
    private readonly coarsest: number,
    private readonly index: LabelIndex | undefined,
  ) {
    this.format = atlasFormat(gl, facts);
    this.unit = unitOf(facts);
    this.pages = nearestTexture(gl, gl.TEXTURE_3D);
    const [x, y, z] = shape.map((slots) => slots * SLOT_SIDE) as unknown as Vec3;
    gl.texStorage3D(gl.TEXTURE_3D, 1, this.format.internal, x, y, z);
    this.entries = nearestTexture(gl, gl.TEXTURE_3D);
    this.reach = nearestTexture(gl, gl.TEXTURE_3D);
  }

  get hasTable(): boolean {
    return this.table !== undefined;
  }

  /** Voxels of level 0 that a sample of the finest level of the table spans. */
  get factor(): Vec3 {
    return this.facts.levels[this.table!.level]!.factor;
  }

  upload(slot: Vec3, page: PageVoxels): void {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_3D, this.pages);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const [x, y, z] = slot.map((at) => at * SLOT_SIDE) as unknown as Vec3;
    const { format, type } = this.format;
    const [s, voxels] = [SLOT_SIDE, this.index?.numbered(page.voxels) ?? this.counted(page.voxels)];
    gl.texSubImage3D(gl.TEXTURE_3D, 0, x, y, z, s, s, s, format, type, voxels as ArrayBufferView);
  }

  private counted<V extends Voxels>(values: V): V {
    return this.unit === 1 ? values : (values.map((v) => v / this.unit) as V);
  }

  setTable(table: RayTable): void {
    const gl = this.gl;
    const [x, y, z] = table.grid;
    this.table = table;
    gl.activeTexture(gl.TEXTURE0);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const put = (texture: WebGLTexture, format: [number, number, number], of: ArrayBufferView) => {
      const [internal, layout, type] = format;
      gl.bindTexture(gl.TEXTURE_3D, texture);
      gl.texImage3D(gl.TEXTURE_3D, 0, internal, x, y, z, 0, layout, type, of);
    };
    put(this.entries, [gl.RGBA8UI, gl.RGBA_INTEGER, gl.UNSIGNED_BYTE], table.entries);
    put(this.reach, [gl.RG32F, gl.RG, gl.FLOAT], this.counted(table.reach));
  }

  /** Gives a shader these pages under a name, in three texture units. */
  bind(cover: Cover, name: string, unit: number): void {
    const gl = this.gl;
    const { level, grid } = this.table!;
    const f = this.factor;
    const ratio = new Float32Array(3 * MOST_LEVELS).fill(1);
    for (let k = level; k <= this.coarsest && k - level < MOST_LEVELS; ++k) {
      for (const a of AXES) ratio[3 * (k - level) + a] = this.facts.levels[k]!.factor[a] / f[a];
    }
    cover.texture(`${name}Atlas`, unit, gl.TEXTURE_3D, this.pages);
    cover.texture(`${name}Table`, unit + 1, gl.TEXTURE_3D, this.entries);
    cover.texture(`${name}Reach`, unit + 2, gl.TEXTURE_3D, this.reach);
    cover.vectors(`${name}Ratio`, ratio);
    cover.ints(`${name}Grid`, ...grid);
  }

  dispose(): void {
    for (const texture of [this.pages, this.entries, this.reach]) this.gl.deleteTexture(texture);
  }
}

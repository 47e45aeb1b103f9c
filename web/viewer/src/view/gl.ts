// WebGL2: programs, textures, and the one triangle that covers everything.

export type Gl = WebGL2RenderingContext;

export class ShaderError extends Error {}

function compiled(gl: Gl, type: number, source: string): WebGLShader {
  const shader = gl.createShader(type);
  if (!shader) throw new ShaderError("the graphics context is lost");
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
    throw new ShaderError(gl.getShaderInfoLog(shader) ?? "a shader does not compile");
  }
  return shader;
}

const COVER = `#version 300 es
void main() {
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}`;

/** A fragment shader over a whole viewport; uniforms are set by name. */
export class Cover {
  private readonly program: WebGLProgram;
  private readonly places = new Map<string, WebGLUniformLocation | null>();

  constructor(
    private readonly gl: Gl,
    fragment: string,
  ) {
    this.program = gl.createProgram();
    const shaders = [
      compiled(gl, gl.VERTEX_SHADER, COVER),
      compiled(gl, gl.FRAGMENT_SHADER, fragment),
    ];
    for (const shader of shaders) gl.attachShader(this.program, shader);
    gl.linkProgram(this.program);
    // They live as long as the program.
    for (const shader of shaders) gl.deleteShader(shader);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS) && !gl.isContextLost()) {
      throw new ShaderError(gl.getProgramInfoLog(this.program) ?? "a program does not link");
    }
  }

  use(): void {
    this.gl.useProgram(this.program);
  }

  private place(name: string): WebGLUniformLocation | null {
    let place = this.places.get(name);
    if (place === undefined) {
      place = this.gl.getUniformLocation(this.program, name);
      this.places.set(name, place);
    }
    return place;
  }

  /** One to four numbers. */
  floats(name: string, ...v: readonly number[]): void {
    const place = this.place(name);
    if (v.length === 1) this.gl.uniform1f(place, v[0]!);
    else if (v.length === 2) this.gl.uniform2f(place, v[0]!, v[1]!);
    else if (v.length === 3) this.gl.uniform3f(place, v[0]!, v[1]!, v[2]!);
    else this.gl.uniform4f(place, v[0]!, v[1]!, v[2]!, v[3]!);
  }

  ints(name: string, ...v: readonly number[]): void {
    const place = this.place(name);
    if (v.length === 1) this.gl.uniform1i(place, v[0]!);
    else if (v.length === 2) this.gl.uniform2i(place, v[0]!, v[1]!);
    else this.gl.uniform3i(place, v[0]!, v[1]!, v[2]!);
  }

  vectors(name: string, values: Float32Array): void {
    this.gl.uniform3fv(this.place(name), values);
  }

  /** A texture at a unit. */
  texture(name: string, unit: number, target: number, texture: WebGLTexture | null): void {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(target, texture);
    this.ints(name, unit);
  }

  draw(): void {
    this.gl.drawArrays(this.gl.TRIANGLES, 0, 3);
  }

  dispose(): void {
    this.gl.deleteProgram(this.program);
  }
}

/** A texture that is read texel by texel. */
export function nearestTexture(gl: Gl, target: number): WebGLTexture {
  const texture = gl.createTexture();
  gl.bindTexture(target, texture);
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  if (target === gl.TEXTURE_3D) {
    gl.texParameteri(target, gl.TEXTURE_WRAP_R, gl.CLAMP_TO_EDGE);
  }
  return texture;
}

export interface TexelFormat {
  readonly internal: number;
  readonly format: number;
  readonly type: number;
  /** The kind of sampler: "" for floats, "i" or "u". */
  readonly sampler: "" | "i" | "u";
  readonly bytes: number;
}

export function texelFormat(gl: Gl, type: string): TexelFormat {
  const rows: Record<string, [number, number, number, "" | "i" | "u", number]> = {
    int8: [gl.R8I, gl.RED_INTEGER, gl.BYTE, "i", 1],
    uint8: [gl.R8UI, gl.RED_INTEGER, gl.UNSIGNED_BYTE, "u", 1],
    int16: [gl.R16I, gl.RED_INTEGER, gl.SHORT, "i", 2],
    uint16: [gl.R16UI, gl.RED_INTEGER, gl.UNSIGNED_SHORT, "u", 2],
    int32: [gl.R32I, gl.RED_INTEGER, gl.INT, "i", 4],
    uint32: [gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, "u", 4],
    float32: [gl.R32F, gl.RED, gl.FLOAT, "", 4],
  };
  const [internal, format, texel, sampler, bytes] = rows[type]!;
  return { internal, format, type: texel, sampler, bytes };
}

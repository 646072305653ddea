/** A face whose vertices a GPU moves, for three.js' WebGPURenderer, with WebGPU and with the WebGL 2 that it falls back to.
 * As FaceBakerGpuMesh of "facebaker/three-gpu", with the passes as nodes (TSL).
 *
 * Positions differ from those of Face.evaluate by rounding, and exact poses are not corrected. */
import { FloatType, MeshStandardNodeMaterial, NearestFilter, NodeMaterial, QuadMesh, RenderTarget, RGBAFormat, UnsignedByteType,
         type DataTexture, type MeshStandardMaterial, type MeshStandardMaterialParameters, type Node, type SkinnedMesh,
         type Texture, type WebGPURenderer } from "three/webgpu";
import { attribute, Break, cross, dot, Fn, If, int, ivec2, length, Loop, normalLocal, positionLocal, screenCoordinate,
         skinning, textureLoad, uint, vec3, vec4 } from "three/tsl";
import type { Face } from "./face.js";
import { textureWidth } from "./gpu_layout.js";
import { GpuFaceGroup, dataTexture, type GpuTextures } from "./three_gpu_group.js";
import type { FaceGroupOptions } from "./three_group.js";

type Uint = Node<"uint">;

const load = (texture: Texture, index: Uint) =>
  textureLoad(texture, ivec2(int(index.mod(uint(textureWidth))), int(index.div(uint(textureWidth)))), int(0));
const integers = (texture: Texture, index: Uint) => load(texture, index) as unknown as Node<"uvec4">;

/** The vertex of a fragment of a pass. */
const thisVertex = (): Uint =>
  uint(screenCoordinate.y).mul(uint(textureWidth)).add(uint(screenCoordinate.x)).toVar() as unknown as Uint;

/** Where the driven joints that a vertex follows take it: core/archive/EVALUATION.md, "Driven joints". */
function skinned(vertex: Uint, at: Node<"vec3">, influences: Texture, matrices: Texture,
                 influenceCount: number): Node<"vec3"> {
  const [x, y, z] = [vec4(0).toVar(), vec4(0).toVar(), vec4(0).toVar()] as const;
  Loop({ start: uint(0), end: uint(influenceCount), type: "uint", condition: "<" }, ({ i }) => {
    const influence = load(influences, vertex.mul(uint(influenceCount)).add(i as unknown as Uint)).toVar();
    If(influence.y.equal(0), () => { Break(); });
    const row = uint(influence.x).mul(3).toVar() as unknown as Uint;
    [x, y, z].forEach((sum, axis) => sum.addAssign(load(matrices, row.add(uint(axis))).mul(influence.y)));
  });
  const from = vec4(at, 1).toVar();
  return at.add(vec3(dot(x, from), dot(y, from), dot(z, from)));
}

/** Rest position plus the digits of the vertex times the weights of the pose, moved by the driven joints that the
 * vertex follows, `influenceCount` at most. */
const positionOf = (textures: GpuTextures, influenceCount: number) => Fn(() => {
  const { digits, blocks, rest, weights, influences, matrices } = textures;
  const vertex = thisVertex(), block = integers(blocks, vertex).toVar(), moved = vec3(0).toVar();
  Loop({ start: uint(0), end: block.w, type: "uint", condition: "<" }, ({ i }) => {
    const c = i as unknown as Uint, weight = load(weights, block.z.add(c)).r.toVar();
    If(weight.notEqual(0), () => {
      const stored = load(digits, block.x.add(c.mul(block.y))).xyz;
      moved.addAssign(stored.mul(255).round().sub(128).mul(weight));
    });
  });
  const at = load(rest, vertex).xyz.add(moved).toVar();
  return vec4(influences && matrices ? skinned(vertex, at, influences, matrices, influenceCount) : at, 1);
})();

/** The normalised sum of the area vectors of the polygons around a vertex. */
const normalOf = (positions: Texture, { around, polygons }: GpuTextures) => Fn(() => {
  const vertex = thisVertex(), entries = integers(around, vertex).toVar(), sum = vec3(0).toVar();
  const at = (index: Uint) => load(positions, index).xyz;
  Loop({ start: uint(0), end: entries.y, type: "uint", condition: "<" }, ({ i }) => {
    const entry = entries.x.add((i as unknown as Uint).mul(2)).toVar() as unknown as Uint;
    const first = integers(polygons, entry).toVar(), last = integers(polygons, entry.add(1)).toVar();
    sum.addAssign(cross(at(first.x).sub(at(first.y)), at(last.x).sub(at(last.y))));
  });
  const size = length(sum);
  return vec4(size.greaterThan(0).select(sum.div(size), vec3(0)), 0);
})();

// A pass over all vertices of the face, whose results land in a texture of floats.
class NodePass {
  readonly target: RenderTarget;
  private readonly material = new NodeMaterial();
  private readonly quad = new QuadMesh(this.material);

  constructor(vertexCount: number, result: Node) {
    this.target = new RenderTarget(textureWidth, Math.ceil(vertexCount / textureWidth), {
      format: RGBAFormat, type: FloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false,
    });
    this.material.fragmentNode = result;
    this.material.depthTest = this.material.depthWrite = false;
  }

  run(renderer: WebGPURenderer): void {
    renderer.setRenderTarget(this.target);
    this.quad.render(renderer);
  }

  dispose(): void {
    this.target.dispose();
    this.material.dispose();
  }
}

// Digits as bytes from 0 to 255: node materials have no textures of signed integers of 8 bits.
const digitTexture = (digits: Int8Array): DataTexture =>
  dataTexture(Uint8Array.from(digits, (digit) => digit + 128), 4, RGBAFormat, UnsignedByteType);

/** As FaceBakerMesh, with `update(controls, renderer)`. Needs a WebGPURenderer that is initialised. */
export class FaceBakerNodeMesh extends GpuFaceGroup {
  private readonly positions: NodePass;
  private readonly normals: NodePass;

  /** Whether this renderer can draw it; once `await renderer.init()` is through. */
  static isSupported(renderer: object): boolean {
    return isWebGPU(renderer) && mostRows(renderer) > 0;
  }

  constructor(face: Face, options: FaceGroupOptions = {}) {
    super(face, options, digitTexture, MeshStandardNodeMaterial as unknown as
      new (parameters: MeshStandardMaterialParameters) => MeshStandardMaterial);
    this.positions = new NodePass(face.vertexCount, positionOf(this.textures, this.influenceCount));
    this.normals = new NodePass(face.vertexCount, normalOf(this.positions.target.texture, this.textures));
    const position = this.lookUp();
    for (const material of this.materials as unknown as MeshStandardNodeMaterial[]) material.positionNode = position;
  }

  // Positions and normals from the textures, then the skin, which three.js has applied to what they replace.
  private lookUp(): Node<"vec3"> {
    const { positions, normals } = this;
    const found = (builder: { object: SkinnedMesh }) => {
      const vertex = attribute("faceVertex", "uint") as unknown as Uint;
      positionLocal.assign(load(positions.target.texture, vertex).xyz);
      normalLocal.assign(load(normals.target.texture, vertex).xyz);
      if (builder.object.isSkinnedMesh) skinning(builder.object);
      return positionLocal;
    };
    return (Fn as unknown as (of: typeof found) => () => Node<"vec3">)(found)();
  }

  /** Poses the face: coefficients and driven joints here, everything else on the renderer's GPU. */
  update(controls: Float32Array, renderer: WebGPURenderer): void {
    if (!isWebGPU(renderer))
      throw new Error('FaceBakerNodeMesh: this is no WebGPURenderer; "facebaker/three-gpu" is for WebGLRenderer');
    if (mostRows(renderer) === 0)
      throw new Error("FaceBakerNodeMesh: `await renderer.init()` comes first, or this browser cannot write floats to textures");
    this.weigh(controls, mostRows(renderer));
    const target = renderer.getRenderTarget(), { xr } = renderer, inXr = xr.enabled;
    xr.enabled = false;
    this.positions.run(renderer);
    this.normals.run(renderer);
    xr.enabled = inXr;
    renderer.setRenderTarget(target);
  }

  /** Reads the last pose back: positions and normals, 3 a vertex. For tests. */
  async read(renderer: WebGPURenderer): Promise<{ positions: Float32Array; normals: Float32Array }> {
    const readOf = async ({ target }: NodePass) => {
      const { width, height } = target;
      const texels = await renderer.readRenderTargetPixelsAsync(target, 0, 0, width, height) as Float32Array;
      return this.unpack("isWebGLBackend" in renderer.backend ? turnRows(texels) : texels);
    };
    return { positions: await readOf(this.positions), normals: await readOf(this.normals) };
  }

  override dispose(): void {
    super.dispose();
    this.positions.dispose();
    this.normals.dispose();
  }
}

function isWebGPU(renderer: object): renderer is WebGPURenderer {
  return "isWebGPURenderer" in renderer;
}

// Of a texture, the last one first: with WebGL three.js' nodes write, and look up, render targets upside down.
function turnRows(texels: Float32Array): Float32Array {
  const row = 4 * textureWidth, turned = new Float32Array(texels.length);
  for (let at = 0; at < texels.length; at += row) turned.set(texels.subarray(at, at + row), texels.length - at - row);
  return turned;
}

// Rows of the largest texture; 0: there is no GPU yet, or none that writes floats.
function mostRows(renderer: WebGPURenderer): number {
  const { device, gl } = renderer.backend as unknown as { device?: GPUDevice; gl?: WebGL2RenderingContext };
  if (device) return device.limits.maxTextureDimension2D;
  return gl?.getExtension("EXT_color_buffer_float") ? (gl.getParameter(gl.MAX_TEXTURE_SIZE) as number) : 0;
}

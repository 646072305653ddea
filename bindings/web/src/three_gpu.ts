/** A face whose vertices a GPU moves. The processor computes the coefficients of a pose, some thousand numbers, and
 * where its driven joints are; the basis lies in a texture as it is stored, a byte a number. A pass writes positions to
 * a texture, once for each vertex of the face, a second one normals; the vertices of the meshes look theirs up, in
 * every pass that draws them, shadows too.
 *
 * Positions differ from those of Face.evaluate by rounding, and exact poses are not corrected (coefficients are without
 * that). */
import {
  BufferAttribute, BufferGeometry, ByteType, FloatType, GLSL3, Mesh, MeshDepthMaterial, MeshDistanceMaterial, NearestFilter,
  OrthographicCamera, RawShaderMaterial, RGBADepthPacking, RGBAFormat, RGBAIntegerFormat, Scene, WebGLRenderTarget,
  type IUniform, type Material, type WebGLProgramParametersWithUniforms, type WebGLRenderer,
} from "three";
import type { Face } from "./face.js";
import { normalShader, positionShader, screenShader, vertexHeader } from "./gpu_shaders.js";
import { textureWidth } from "./gpu_layout.js";
import { GpuFaceGroup, dataTexture } from "./three_gpu_group.js";
import type { FaceGroupOptions } from "./three_group.js";

// A pass over all vertices of the face, whose results land in a texture of floats.
class VertexPass {
  readonly target: WebGLRenderTarget;
  private readonly scene = new Scene();
  private readonly camera = new OrthographicCamera();
  private readonly material: RawShaderMaterial;

  constructor(vertexCount: number, fragmentShader: string, uniforms: Record<string, IUniform>) {
    this.target = new WebGLRenderTarget(textureWidth, Math.ceil(vertexCount / textureWidth), {
      format: RGBAFormat, type: FloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false,
    });
    this.material = new RawShaderMaterial({ glslVersion: GLSL3, vertexShader: screenShader, fragmentShader, uniforms,
                                            depthTest: false, depthWrite: false });
    const triangle = new BufferGeometry(); // covers the target
    triangle.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const mesh = new Mesh(triangle, this.material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
  }

  run(renderer: WebGLRenderer): void {
    renderer.setRenderTarget(this.target);
    renderer.render(this.scene, this.camera);
  }

  dispose(): void {
    this.target.dispose();
    this.material.dispose();
    (this.scene.children[0] as Mesh).geometry.dispose();
  }
}

/** As FaceBakerMesh, with `update(controls, renderer)`. Needs a WebGLRenderer with EXT_color_buffer_float; for
 * WebGPURenderer there is FaceBakerNodeMesh of "facebaker/three-webgpu". */
export class FaceBakerGpuMesh extends GpuFaceGroup {
  private readonly positions: VertexPass;
  private readonly normals: VertexPass;
  private readonly depthMaterials: readonly Material[];

  /** Whether this renderer can draw it. */
  static isSupported(renderer: object): boolean {
    return isWebGL(renderer) && renderer.getContext().getExtension("EXT_color_buffer_float") !== null;
  }

  constructor(face: Face, options: FaceGroupOptions = {}) {
    super(face, options, (digits) => dataTexture(digits, 4, RGBAIntegerFormat, ByteType));
    const { digits, blocks, around, polygons } = this.textures;
    digits.internalFormat = "RGBA8I";
    blocks.internalFormat = "RGBA32UI";
    around.internalFormat = polygons.internalFormat = "RG32UI";
    const uniforms = Object.fromEntries(Object.entries(this.textures).map(([name, value]) => [name, { value }]));
    uniforms["vertexCount"] = { value: face.vertexCount as never };
    this.positions = new VertexPass(face.vertexCount, positionShader(this.influenceCount), uniforms);
    this.normals = new VertexPass(face.vertexCount, normalShader,
                                  { ...uniforms, positions: { value: this.positions.target.texture } });
    const depth = new MeshDepthMaterial({ depthPacking: RGBADepthPacking }), distance = new MeshDistanceMaterial();
    this.depthMaterials = [depth, distance];
    for (const material of [...this.materials, ...this.depthMaterials])
      material.onBeforeCompile = (shader) => this.lookUp(shader);
    for (const mesh of this.meshes) {
      mesh.customDepthMaterial = depth;
      mesh.customDistanceMaterial = distance;
    }
  }

  // Has a material of three.js take positions and normals from the textures.
  private lookUp(shader: WebGLProgramParametersWithUniforms): void {
    shader.uniforms["facePositions"] = { value: this.positions.target.texture };
    shader.uniforms["faceNormals"] = { value: this.normals.target.texture };
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", `#include <common>\n${vertexHeader}`)
      .replace("#include <beginnormal_vertex>", "vec3 objectNormal = texelFetch(faceNormals, faceTexel(), 0).xyz;")
      .replace("#include <begin_vertex>", "vec3 transformed = texelFetch(facePositions, faceTexel(), 0).xyz;");
  }

  /** Poses the face: coefficients and driven joints here, everything else on the renderer's GPU. */
  update(controls: Float32Array, renderer: WebGLRenderer): void {
    if (!isWebGL(renderer))
      throw new Error('FaceBakerGpuMesh: this is no WebGLRenderer; "facebaker/three-webgpu" is for WebGPURenderer');
    if (!FaceBakerGpuMesh.isSupported(renderer))
      throw new Error("FaceBakerGpuMesh: this browser cannot write floats to textures (EXT_color_buffer_float)");
    this.weigh(controls, renderer.capabilities.maxTextureSize);
    const target = renderer.getRenderTarget(), clearing = renderer.autoClear, { xr, shadowMap } = renderer;
    const inXr = xr.enabled, shadows = shadowMap.autoUpdate;
    renderer.autoClear = xr.enabled = shadowMap.autoUpdate = false;
    this.positions.run(renderer);
    this.normals.run(renderer);
    renderer.autoClear = clearing;
    xr.enabled = inXr;
    shadowMap.autoUpdate = shadows;
    renderer.setRenderTarget(target);
  }

  /** Reads the last pose back: positions and normals, 3 a vertex. For tests; it waits for the GPU. */
  read(renderer: WebGLRenderer): { positions: Float32Array; normals: Float32Array } {
    const readOf = ({ target }: VertexPass) => {
      const texels = new Float32Array(4 * target.width * target.height);
      renderer.readRenderTargetPixels(target, 0, 0, target.width, target.height, texels);
      return this.unpack(texels);
    };
    return { positions: readOf(this.positions), normals: readOf(this.normals) };
  }

  override dispose(): void {
    super.dispose();
    for (const material of this.depthMaterials) material.dispose();
    this.positions.dispose();
    this.normals.dispose();
  }
}

function isWebGL(renderer: object): renderer is WebGLRenderer {
  return "isWebGLRenderer" in renderer;
}

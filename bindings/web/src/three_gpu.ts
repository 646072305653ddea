/** A face whose vertices a GPU moves. The processor computes the coefficients of a pose, some thousand numbers; the basis
 * lies in a texture as it is stored, a byte a number. A pass writes positions to a texture, once for each vertex
 * of the face, a second one normals; the vertices of the meshes look theirs up, in every pass that draws them, shadows
 * too.
 *
 * Positions differ from those of Face.evaluate by rounding, and exact poses are not corrected (coefficients are without
 * that). */
import {
  BufferAttribute, BufferGeometry, DataTexture, FloatType, GLSL3, Group, Mesh, MeshDepthMaterial, MeshDistanceMaterial,
  NearestFilter, OrthographicCamera, RawShaderMaterial, RedFormat, RGBADepthPacking, RGBAFormat, RGBAIntegerFormat, ByteType,
  Scene, Sphere, Vector3, WebGLRenderTarget, RGIntegerFormat, UnsignedIntType,
  type IUniform, type Material, type MeshStandardMaterial, type WebGLProgramParametersWithUniforms, type WebGLRenderer,
} from "three";
import type { Face } from "./face.js";
import { normalShader, positionShader, screenShader, vertexHeader } from "./gpu_shaders.js";
import { layOutBasis, layOutCorners, textureWidth, type GpuBasis } from "./gpu_layout.js";
import { renderMeshes } from "./render_mesh.js";
import { MaterialSet, loadImage } from "./three_materials.js";
import type { FaceBakerMeshOptions } from "./three.js";

const nearest = <Texture extends DataTexture>(texture: Texture): Texture => {
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
};

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

/** As FaceBakerMesh, with `update(controls, renderer)`. Needs WebGL 2 with EXT_color_buffer_float. */
export class FaceBakerGpuMesh extends Group {
  readonly meshes: readonly Mesh<BufferGeometry, MeshStandardMaterial[]>[];
  readonly materials: readonly MeshStandardMaterial[];
  /** Bytes of the basis in its texture. */
  readonly basisBytes: number;
  private readonly materialSet: MaterialSet;
  private readonly basis: GpuBasis;
  private readonly weights: DataTexture;
  private readonly coefficients: Float32Array;
  private readonly textures: readonly DataTexture[];
  private readonly positions: VertexPass;
  private readonly normals: VertexPass;
  private readonly depthMaterials: Material[] = [];

  static isSupported(renderer: WebGLRenderer): boolean {
    return renderer.getContext().getExtension("EXT_color_buffer_float") !== null;
  }

  constructor(private readonly face: Face, options: Pick<FaceBakerMeshOptions, "loadTexture"> = {}) {
    super();
    this.name = face.name;
    this.materialSet = new MaterialSet(face, options.loadTexture ?? loadImage);
    this.materials = this.materialSet.all;
    this.basis = layOutBasis(face);
    const { basis } = this, corners = layOutCorners(face);
    const texture = (data: ArrayBufferView, texels: number, format: number, type: number) =>
      nearest(new DataTexture(data as never, textureWidth, texels / textureWidth, format as never, type as never));
    const digits = texture(basis.digits, basis.digits.length / 4, RGBAIntegerFormat, ByteType);
    digits.internalFormat = "RGBA8I";
    const blocks = texture(basis.blockOfVertex, basis.blockOfVertex.length / 4, RGBAIntegerFormat, UnsignedIntType);
    blocks.internalFormat = "RGBA32UI";
    const rest = texture(basis.rest, basis.rest.length / 4, RGBAFormat, FloatType);
    const around = texture(corners.around, corners.around.length / 2, RGIntegerFormat, UnsignedIntType);
    around.internalFormat = "RG32UI";
    const polygons = texture(corners.polygons, corners.polygons.length / 2, RGIntegerFormat, UnsignedIntType);
    polygons.internalFormat = "RG32UI";
    this.weights = texture(basis.weights, basis.weights.length, RedFormat, FloatType);
    this.textures = [digits, blocks, rest, around, polygons, this.weights];
    this.coefficients = new Float32Array(face.coefficientCount);
    this.basisBytes = basis.digits.length;
    this.positions = new VertexPass(face.vertexCount, positionShader, {
      digits: { value: digits }, blocks: { value: blocks }, rest: { value: rest }, weights: { value: this.weights },
      vertexCount: { value: face.vertexCount },
    });
    this.normals = new VertexPass(face.vertexCount, normalShader, {
      positions: { value: this.positions.target.texture }, around: { value: around }, polygons: { value: polygons },
      vertexCount: { value: face.vertexCount },
    });
    for (const material of this.materials) material.onBeforeCompile = (shader) => this.lookUp(shader);
    this.meshes = this.makeMeshes();
    if (this.meshes.length > 0) this.add(...this.meshes);
    if (face.upAxis === "z") this.rotation.x = -Math.PI / 2;
  }

  private makeMeshes(): Mesh<BufferGeometry, MeshStandardMaterial[]>[] {
    const { face } = this;
    const depth = new MeshDepthMaterial({ depthPacking: RGBADepthPacking }), distance = new MeshDistanceMaterial();
    for (const material of [depth, distance]) material.onBeforeCompile = (shader) => this.lookUp(shader);
    this.depthMaterials.push(depth, distance);
    // Twice the diagonal around the rest mesh: no pose is known before the GPU has it.
    const sphere = new Sphere(new Vector3(), 0);
    const rest = face.restPositions;
    for (let v = 0; v < face.vertexCount; ++v)
      sphere.center.add(new Vector3(rest[3 * v], rest[3 * v + 1], rest[3 * v + 2]).divideScalar(face.vertexCount));
    sphere.radius = 2 * face.diagonal;
    return renderMeshes(face).map((render, index) => {
      const geometry = new BufferGeometry();
      // three.js counts vertices by `position`; the shader replaces it.
      const position = new Float32Array(3 * render.vertexCount);
      render.source.forEach((from, v) => position.set(rest.subarray(3 * from, 3 * from + 3), 3 * v));
      geometry.setAttribute("position", new BufferAttribute(position, 3));
      geometry.setAttribute("normal", new BufferAttribute(new Float32Array(3 * render.vertexCount), 3));
      geometry.setAttribute("faceVertex", new BufferAttribute(new Uint32Array(render.source), 1));
      if (render.uvs) geometry.setAttribute("uv", new BufferAttribute(render.uvs, 2));
      geometry.setIndex(new BufferAttribute(render.indices, 1));
      render.groups.forEach(({ start, count }, group) => geometry.addGroup(start, count, group));
      geometry.boundingSphere = sphere;
      const mesh = new Mesh(geometry, render.groups.map(({ material }) => this.materialSet.at(material)));
      mesh.name = face.meshes[index]!.name;
      mesh.customDepthMaterial = depth;
      mesh.customDistanceMaterial = distance;
      return mesh;
    });
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

  /** Poses the face: coefficients here, everything else on the renderer's GPU. */
  update(controls: Float32Array, renderer: WebGLRenderer): void {
    if (!FaceBakerGpuMesh.isSupported(renderer))
      throw new Error("FaceBakerGpuMesh: this browser cannot write floats to textures (EXT_color_buffer_float)");
    const { basis, coefficients } = this;
    this.face.coefficients(controls, coefficients);
    for (let i = 0; i < basis.columns.length; ++i)
      basis.weights[i] = coefficients[basis.columns[i]!]! * basis.scales[i]!;
    this.weights.needsUpdate = true;
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
      const texels = new Float32Array(4 * target.width * target.height), values = new Float32Array(3 * this.face.vertexCount);
      renderer.readRenderTargetPixels(target, 0, 0, target.width, target.height, texels);
      for (let i = 0; i < values.length; ++i) values[i] = texels[4 * Math.floor(i / 3) + (i % 3)]!;
      return values;
    };
    return { positions: readOf(this.positions), normals: readOf(this.normals) };
  }

  /** Frees what it has on the GPU; the face stays. */
  override dispose(): void {
    for (const { geometry } of this.meshes) geometry.dispose();
    for (const texture of this.textures) texture.dispose();
    for (const material of this.depthMaterials) material.dispose();
    this.positions.dispose();
    this.normals.dispose();
    this.materialSet.dispose();
    this.removeFromParent();
  }
}

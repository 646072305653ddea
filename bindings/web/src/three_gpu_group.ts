// What faces whose vertices a GPU moves have in common: the basis in a texture, meshes that name the vertex of the face
// that each vertex is, the weights of a pose and what its driven joints do.
import { BufferAttribute, BufferGeometry, DataTexture, NearestFilter, Sphere, Vector3, FloatType, RedFormat, RGBAFormat,
         RGBAIntegerFormat, RGFormat, RGIntegerFormat, UnsignedIntType, type MeshStandardMaterial,
         type MeshStandardMaterialParameters } from "three";
import type { Face } from "./face.js";
import { layOutBasis, layOutCorners, layOutSkin, textureWidth, type GpuBasis } from "./gpu_layout.js";
import { renderMeshes } from "./render_mesh.js";
import { DrivenMatrices } from "./three_driven_joints.js";
import { FaceGroup, type FaceGroupOptions, type FaceMesh } from "./three_group.js";

/** Textures that the passes read. Those of the digits differ. */
export interface GpuTextures {
  readonly digits: DataTexture;
  readonly blocks: DataTexture;
  readonly rest: DataTexture;
  readonly around: DataTexture;
  readonly polygons: DataTexture;
  readonly weights: DataTexture;
  // Of a face with driven joints:
  readonly influences?: DataTexture;
  readonly matrices?: DataTexture;
}

/** A texture of gpu_layout.ts, `size` numbers a texel. */
export function dataTexture(data: ArrayBufferView & { length: number }, size: number, format: number, type: number): DataTexture {
  const texture = new DataTexture(data as never, textureWidth, data.length / size / textureWidth, format as never, type as never);
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

export abstract class GpuFaceGroup extends FaceGroup {
  /** By mesh of the character. */
  readonly meshes: readonly FaceMesh[];
  /** Bytes of the basis in its texture. */
  readonly basisBytes: number;
  protected readonly textures: GpuTextures;
  /** Driven joints that a vertex follows at most; 0 without any. */
  protected readonly influenceCount: number;
  private readonly basis: GpuBasis;
  private readonly coefficients: Float32Array;
  private readonly driven: DrivenMatrices | null;

  /** `makeDigits`: a texture of them that the passes can read. */
  protected constructor(
      protected readonly face: Face, options: FaceGroupOptions, makeDigits: (digits: Int8Array) => DataTexture,
      Material?: new (parameters: MeshStandardMaterialParameters) => MeshStandardMaterial) {
    super(face, options, Material);
    const basis = layOutBasis(face), corners = layOutCorners(face), skin = layOutSkin(face);
    this.basis = basis;
    this.basisBytes = basis.digits.length;
    this.coefficients = new Float32Array(face.coefficientCount);
    this.driven = skin && new DrivenMatrices(face, skin.matrices);
    this.influenceCount = skin?.influenceCount ?? 0;
    this.textures = {
      digits: makeDigits(basis.digits),
      blocks: dataTexture(basis.blockOfVertex, 4, RGBAIntegerFormat, UnsignedIntType),
      rest: dataTexture(basis.rest, 4, RGBAFormat, FloatType),
      around: dataTexture(corners.around, 2, RGIntegerFormat, UnsignedIntType),
      polygons: dataTexture(corners.polygons, 2, RGIntegerFormat, UnsignedIntType),
      weights: dataTexture(basis.weights, 1, RedFormat, FloatType),
      ...(skin && { influences: dataTexture(skin.influences, 2, RGFormat, FloatType),
                    matrices: dataTexture(skin.matrices, 4, RGBAFormat, FloatType) }),
    };
    this.meshes = this.makeMeshes();
  }

  private makeMeshes(): FaceMesh[] {
    const { face } = this;
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
      geometry.boundingSphere = sphere;
      return this.makeMesh(geometry, render, face.meshes[index]!.name);
    });
  }

  /** Computes the weights of a pose and the matrices of its driven joints, for a GPU whose textures have at most so
   * many rows. */
  protected weigh(controls: Float32Array, mostRows: number): void {
    const { basis, coefficients, textures } = this;
    for (const [name, { image }] of Object.entries(textures) as [string, { image: { height: number } }][])
      if (image.height > mostRows)
        throw new Error(`the face is too large for this GPU: its ${name} take ${image.height} rows of a texture, of ${mostRows}`);
    this.face.coefficients(controls, coefficients);
    for (let i = 0; i < basis.columns.length; ++i)
      basis.weights[i] = coefficients[basis.columns[i]!]! * basis.scales[i]!;
    textures.weights.needsUpdate = true;
    this.driven?.update(controls);
    if (textures.matrices) textures.matrices.needsUpdate = true;
  }

  /** What a pass has written, 3 numbers a vertex, from texels of 4. */
  protected unpack(texels: ArrayLike<number>): Float32Array {
    return Float32Array.from({ length: 3 * this.face.vertexCount }, (_, i) => texels[4 * Math.floor(i / 3) + (i % 3)]!);
  }

  /** As of FaceBakerMesh; after it `update` poses the face again. */
  override dispose(): void {
    super.dispose();
    for (const texture of Object.values(this.textures) as DataTexture[]) texture.dispose();
  }
}

/** A face in a scene of three.js. */
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Group, Mesh, Object3D, Sphere,
         type MeshStandardMaterial } from "three";
import type { FaceContents } from "./contents.js";
import type { Face } from "./face.js";
import { renderMeshes, scatter, type RenderMesh } from "./render_mesh.js";
import { MaterialSet, loadImage, type LoadTexture } from "./three_materials.js";
import type { Outputs } from "./model.js";

export { loadImage, type LoadTexture } from "./three_materials.js";

export interface FaceBakerMeshOptions {
  /** Whether normals follow the pose; true by default. */
  normals?: boolean;
  /** The level of detail whose polygons are drawn; 0, the whole, by default. */
  level?: number;
  /** Makes textures; by default of what the browser decodes itself. For KTX2 give one that uses KTX2Loader. */
  loadTexture?: LoadTexture;
}

/** What a pose has, see Outputs of "facebaker". */
export type PosedVertices = Pick<Outputs, "normals" | "sockets" | "bounds"> & { positions: Float32Array };

// One mesh with the array that its geometry draws from.
interface Part {
  readonly mesh: Mesh<BufferGeometry, MeshStandardMaterial[]>;
  readonly render: RenderMesh;
}

/** One Mesh for each mesh of the character. `update` poses it; `apply` takes poses that were evaluated elsewhere, such as
 * in a worker. Buffers are filled in place, nothing is allocated. Of faces whose up axis is z the group is turned. */
export class FaceBakerMesh extends Group {
  /** By mesh of the character. */
  readonly meshes: readonly Mesh<BufferGeometry, MeshStandardMaterial[]>[];
  /** By material of the face; the last one is for polygons without material. */
  readonly materials: readonly MeshStandardMaterial[];
  /** By socket of the face: they move with the surface; hang something on them by `add`. */
  readonly sockets: readonly Object3D[];
  private readonly parts: readonly Part[];
  private readonly materialSet: MaterialSet;
  private readonly outputs: Required<Pick<Outputs, "positions" | "bounds">> & Outputs;
  private readonly face: Face | null;
  private readonly level: number;
  private readonly sphere = new Sphere();

  /** `face`: a loaded one, or the contents of one in a worker. */
  constructor(face: Face | FaceContents, options: FaceBakerMeshOptions = {}) {
    super();
    this.name = face.name;
    this.face = "evaluateInto" in face ? face : null;
    this.level = Math.min(options.level ?? 0, face.levels.length - 1);
    this.materialSet = new MaterialSet(face, options.loadTexture ?? loadImage);
    this.materials = this.materialSet.all;
    const normals = options.normals ?? true;
    this.outputs = { positions: new Float32Array(3 * face.vertexCount), bounds: new Float32Array(6) };
    if (normals) this.outputs.normals = new Float32Array(3 * face.vertexCount);
    if (face.sockets.length > 0) this.outputs.sockets = new Float32Array(12 * face.sockets.length);
    this.parts = renderMeshes(face, face.levels[this.level]?.meshes).map((render, index) =>
      this.makePart(render, face.meshes[index]!.name, normals));
    this.meshes = this.parts.map(({ mesh }) => mesh);
    this.sockets = face.sockets.map(({ name, frame }) => {
      const socket = new Object3D();
      socket.name = name;
      socket.matrixAutoUpdate = false;
      setFrame(socket, frame, 0);
      return socket;
    });
    if (this.meshes.length > 0) this.add(...this.meshes);
    if (this.sockets.length > 0) this.add(...this.sockets);
    if (face.upAxis === "z") this.rotation.x = -Math.PI / 2;
    if (this.face) this.update(face.restControls);
    else {
      this.apply({ positions: face.restPositions });
      if (normals) for (const mesh of this.meshes) mesh.geometry.computeVertexNormals();
    }
  }

  private makePart(render: RenderMesh, name: string, normals: boolean): Part {
    const geometry = new BufferGeometry();
    const dynamic = () => new BufferAttribute(new Float32Array(3 * render.vertexCount), 3).setUsage(DynamicDrawUsage);
    geometry.setAttribute("position", dynamic());
    if (normals) geometry.setAttribute("normal", dynamic());
    if (render.uvs) geometry.setAttribute("uv", new BufferAttribute(render.uvs, 2));
    geometry.setIndex(new BufferAttribute(
      render.vertexCount < 65536 ? Uint16Array.from(render.indices) : render.indices, 1));
    render.groups.forEach(({ start, count }, index) => geometry.addGroup(start, count, index));
    geometry.boundingSphere = this.sphere;
    const mesh = new Mesh(geometry, render.groups.map(({ material }) => this.materialSet.at(material)));
    mesh.name = name;
    return { mesh, render };
  }

  /** Poses the face. `lod`: between this level of detail and the next one, 0 to 1, positions slide continuously. */
  update(controls: Float32Array, lod = 0): void {
    if (!this.face) throw new Error("FaceBakerMesh: made of contents alone, it poses by apply()");
    this.outputs.lod = this.level + lod;
    this.apply(this.face.evaluateInto(controls, this.outputs));
  }

  /** Shows a pose that was evaluated elsewhere. Without normals those of the pose before stay. */
  apply(pose: PosedVertices): void {
    for (const { mesh, render } of this.parts) {
      fill(mesh.geometry.getAttribute("position") as BufferAttribute, render, pose.positions);
      const normal = mesh.geometry.getAttribute("normal") as BufferAttribute | undefined;
      if (normal && pose.normals) fill(normal, render, pose.normals);
    }
    if (pose.sockets)
      for (let i = 0; i < this.sockets.length; ++i) setFrame(this.sockets[i]!, pose.sockets, 12 * i);
    this.setBounds(pose.bounds ?? boundsOf(pose.positions, this.outputs.bounds));
  }

  /** Frees geometries, materials and textures; the face stays. */
  override dispose(): void {
    for (const { mesh } of this.parts) mesh.geometry.dispose();
    this.materialSet.dispose();
    this.removeFromParent();
  }

  private setBounds(bounds: Float32Array): void {
    const { center } = this.sphere;
    center.set((bounds[0]! + bounds[3]!) / 2, (bounds[1]! + bounds[4]!) / 2, (bounds[2]! + bounds[5]!) / 2);
    this.sphere.radius = Math.hypot(bounds[3]! - center.x, bounds[4]! - center.y, bounds[5]! - center.z);
  }
}

function boundsOf(positions: Float32Array, bounds: Float32Array): Float32Array {
  bounds.fill(Infinity, 0, 3).fill(-Infinity, 3);
  for (let i = 0; i < positions.length; ++i) {
    const axis = i % 3, value = positions[i]!;
    if (value < bounds[axis]!) bounds[axis] = value;
    if (value > bounds[3 + axis]!) bounds[3 + axis] = value;
  }
  return bounds;
}

function fill(attribute: BufferAttribute, render: RenderMesh, values: Float32Array): void {
  scatter(render, values, attribute.array as Float32Array);
  attribute.needsUpdate = true;
}

// The upper three rows of a matrix, row after row.
function setFrame(object: Object3D, f: ArrayLike<number>, at: number): void {
  object.matrix.set(f[at]!, f[at + 1]!, f[at + 2]!, f[at + 3]!, f[at + 4]!, f[at + 5]!, f[at + 6]!, f[at + 7]!,
                    f[at + 8]!, f[at + 9]!, f[at + 10]!, f[at + 11]!, 0, 0, 0, 1);
  object.matrixWorldNeedsUpdate = true;
}

/** A face in a scene of three.js. */
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Matrix4, Object3D, Sphere, Vector3, type SkinnedMesh } from "three";
import type { FaceContents } from "./contents.js";
import type { Face } from "./face.js";
import { renderMeshes, scatter, type RenderMesh } from "./render_mesh.js";
import { FaceGroup, type FaceGroupOptions, type FaceMesh } from "./three_group.js";
import { matrixOf } from "./three_skin.js";
import type { Outputs } from "./model.js";

export type { FaceGroupEvents, FaceMesh } from "./three_group.js";
export { loadImage, type LoadTexture } from "./three_materials.js";

export interface FaceBakerMeshOptions extends FaceGroupOptions {
  /** Whether normals follow the pose; true by default. */
  normals?: boolean;
  /** The level of detail whose polygons are drawn; 0, the whole, by default. */
  level?: number;
}

/** What a pose has, see Outputs of "facebaker". */
export type PosedVertices = Pick<Outputs, "normals" | "sockets" | "bounds"> & { positions: Float32Array };

// One mesh with the array that its geometry draws from.
interface Part {
  readonly mesh: FaceMesh;
  readonly render: RenderMesh;
}

/** One Mesh for each mesh of the character, on the archive's skin where it has one. `update` poses it; `apply` takes
 * poses that were evaluated elsewhere, such as in a worker. Buffers are filled in place, nothing is allocated. */
export class FaceBakerMesh extends FaceGroup {
  /** By mesh of the character. */
  readonly meshes: readonly FaceMesh[];
  /** By socket of the face: they move with the surface and its joints; hang something on them by `add`. With `metres`
   * what hangs there is in metres. */
  readonly sockets: readonly Object3D[];
  private readonly parts: readonly Part[];
  private readonly outputs: Required<Pick<Outputs, "positions" | "bounds">> & Outputs;
  private readonly face: Face | null;
  private readonly level: number;
  private readonly sphere = new Sphere();
  private readonly frames: readonly Matrix4[]; // of sockets, before the skin
  private readonly unscaled: Vector3; // what hangs on sockets is not scaled

  /** `face`: a loaded one, or the contents of one in a worker. */
  constructor(face: Face | FaceContents, options: FaceBakerMeshOptions = {}) {
    super(face, options);
    this.face = "evaluateInto" in face ? face : null;
    this.level = Math.min(options.level ?? 0, face.levels.length - 1);
    const normals = options.normals ?? true;
    this.outputs = { positions: new Float32Array(3 * face.vertexCount), bounds: new Float32Array(6) };
    if (normals) this.outputs.normals = new Float32Array(3 * face.vertexCount);
    if (face.sockets.length > 0) this.outputs.sockets = new Float32Array(12 * face.sockets.length);
    this.parts = renderMeshes(face, face.levels[this.level]?.meshes).map((render, index) =>
      this.makePart(render, face.meshes[index]!.name, normals));
    this.meshes = this.parts.map(({ mesh }) => mesh);
    this.unscaled = new Vector3().setScalar(1 / this.scale.x);
    this.frames = face.sockets.map(() => new Matrix4());
    this.sockets = face.sockets.map(({ name }) => {
      const socket = new Object3D();
      socket.name = name;
      socket.matrixAutoUpdate = false;
      return socket;
    });
    face.sockets.forEach(({ frame }, index) => this.setSocket(index, frame, 0));
    if (this.sockets.length > 0) this.add(...this.sockets);
    if (this.face) this.update(face.restControls);
    else {
      this.apply({ positions: face.restPositions });
      if (normals) for (const mesh of this.meshes) mesh.geometry.computeVertexNormals();
    }
    this.updateMatrixWorld(true); // a skin's bounding boxes are asked for before the first picture
  }

  private makePart(render: RenderMesh, name: string, normals: boolean): Part {
    const geometry = new BufferGeometry();
    const dynamic = () => new BufferAttribute(new Float32Array(3 * render.vertexCount), 3).setUsage(DynamicDrawUsage);
    geometry.setAttribute("position", dynamic());
    if (normals) geometry.setAttribute("normal", dynamic());
    if (render.uvs) geometry.setAttribute("uv", new BufferAttribute(render.uvs, 2));
    geometry.setIndex(new BufferAttribute(
      render.vertexCount < 65536 ? Uint16Array.from(render.indices) : render.indices, 1));
    geometry.boundingSphere = this.sphere;
    return { mesh: this.makeMesh(geometry, render, name), render };
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
    if (pose.sockets) for (let i = 0; i < this.sockets.length; ++i) this.setSocket(i, pose.sockets, 12 * i);
    this.setBounds(pose.bounds ?? boundsOf(pose.positions, this.outputs.bounds));
  }

  /** As of every object; sockets then follow the joints. */
  override updateMatrixWorld(force?: boolean): void {
    super.updateMatrixWorld(force);
    if (!this.skin || !this.sockets) return; // while it is constructed
    this.sockets.forEach((socket, index) => {
      this.skin!.carry(index, this.frames[index]!, this.matrixWorld, socket.matrix);
      socket.updateMatrixWorld(true);
    });
  }

  private setSocket(index: number, frames: ArrayLike<number>, at: number): void {
    const frame = matrixOf(frames, at, this.frames[index]!), socket = this.sockets[index]!;
    frame.scale(this.unscaled);
    if (!this.skin) socket.matrix.copy(frame);
    socket.matrixWorldNeedsUpdate = true;
  }

  private setBounds(bounds: Float32Array): void {
    const { center } = this.sphere;
    center.set((bounds[0]! + bounds[3]!) / 2, (bounds[1]! + bounds[4]!) / 2, (bounds[2]! + bounds[5]!) / 2);
    this.sphere.radius = Math.hypot(bounds[3]! - center.x, bounds[4]! - center.y, bounds[5]! - center.z);
    if (this.skin) // three.js computes them of the skinned mesh where somebody asks
      for (const mesh of this.meshes) if (isSkinned(mesh)) mesh.boundingBox = mesh.boundingSphere = null!;
  }
}

const isSkinned = (mesh: object): mesh is SkinnedMesh => "isSkinnedMesh" in mesh;

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

/** A face in a scene of Babylon.js. */
import type { Bone } from "@babylonjs/core/Bones/bone.js";
import type { Skeleton } from "@babylonjs/core/Bones/skeleton.js";
import type { BoundingInfo } from "@babylonjs/core/Culling/boundingInfo.js";
import { VertexBuffer } from "@babylonjs/core/Buffers/buffer.js";
import { Material } from "@babylonjs/core/Materials/material.js";
import { MultiMaterial } from "@babylonjs/core/Materials/multiMaterial.js";
import type { PBRMaterial } from "@babylonjs/core/Materials/PBR/pbrMaterial.js";
import { Vector3 } from "@babylonjs/core/Maths/math.vector.js";
import { Mesh } from "@babylonjs/core/Meshes/mesh.js";
import { SubMesh } from "@babylonjs/core/Meshes/subMesh.js";
import { TransformNode } from "@babylonjs/core/Meshes/transformNode.js";
import type { Scene } from "@babylonjs/core/scene.js";
import { BabylonMaterials } from "./babylon_materials.js";
import { FollowedBody, makeSkeleton } from "./babylon_skin.js";
import type { Face } from "./face.js";
import { influenceCount, PosedFace, strongestInfluences, type FaceOptions } from "./posed_face.js";
import { scatter, type RenderMesh } from "./render_mesh.js";
import { metresPerUnit, scaleToMetres } from "./units.js";

// One mesh with the arrays that its buffers are filled from.
interface Part {
  readonly mesh: Mesh;
  readonly render: RenderMesh;
  readonly positions: Float32Array;
  readonly normals: Float32Array;
}

/** A node with a Mesh for each mesh of the character, on the archive's skin where it has one. It stands in the scene as a
 * glTF file would: in a left-handed scene what is inside of it is mirrored, so that left stays left. Buffers are filled
 * in place, nothing is allocated. */
export class FaceBakerNode extends TransformNode {
  /** By mesh of the character. */
  readonly meshes: readonly Mesh[];
  /** By material of the face; the last one is for polygons without material. */
  readonly materials: readonly PBRMaterial[];
  /** What the meshes are on; null without a skin. */
  readonly skeleton: Skeleton | null;
  /** By joint of the face; none without a skin. They are at rest until the page turns them. */
  readonly bones: readonly Bone[];
  /** Metres of the unit that positions are in; null where the archive's is not known. */
  readonly metresPerUnit: number | null;
  /** When all pictures are decoded; those that cannot be are left out. */
  readonly ready: Promise<void>;
  private readonly posed: PosedFace;
  private readonly parts: readonly Part[];
  private readonly materialSet: BabylonMaterials;
  private readonly space: TransformNode; // of positions
  private followed: FollowedBody | null = null;
  private readonly minimum = new Vector3();
  private readonly maximum = new Vector3();

  constructor(face: Face, scene: Scene, options: FaceOptions = {}) {
    super(face.name, scene);
    this.posed = new PosedFace(face, options);
    this.metresPerUnit = metresPerUnit(face.units);
    this.space = new TransformNode("space of positions", scene);
    this.space.parent = this;
    if (options.metres) this.space.scaling.setAll(scaleToMetres(face.units));
    if (face.upAxis === "z") this.space.rotation.x = -Math.PI / 2;
    if (!scene.useRightHandedSystem) this.space.scaling.x *= -1;
    this.materialSet = new BabylonMaterials(face, scene);
    this.materials = this.materialSet.all;
    this.ready = this.materialSet.ready;
    this.skeleton = (options.skin ?? true) && face.skin ? makeSkeleton(face, scene) : null;
    this.bones = face.joints.map((_, joint) => this.skeleton?.bones.find((bone) => bone.getIndex() === joint))
      .filter((bone) => bone !== undefined);
    this.parts = this.posed.meshes.map((render, index) => this.makePart(render, face.meshes[index]!.name, scene));
    this.meshes = this.parts.map(({ mesh }) => mesh);
    this.fill();
  }

  private makePart(render: RenderMesh, name: string, scene: Scene): Part {
    const mesh = new Mesh(name, scene, this.space);
    const positions = new Float32Array(3 * render.vertexCount), normals = new Float32Array(positions.length);
    mesh.setVerticesData(VertexBuffer.PositionKind, positions, true);
    mesh.setVerticesData(VertexBuffer.NormalKind, normals, true);
    if (render.uvs) mesh.setVerticesData(VertexBuffer.UVKind, render.uvs);
    const influences = this.skeleton ? strongestInfluences(this.posed.face.skin!, render) : null;
    if (influences) {
      mesh.setVerticesData(VertexBuffer.MatricesIndicesKind, Float32Array.from(influences.joints), false, influenceCount);
      mesh.setVerticesData(VertexBuffer.MatricesWeightsKind, influences.weights, false, influenceCount);
      mesh.skeleton = this.skeleton;
      mesh.alwaysSelectAsActiveMesh = true; // where bones take it is known to the GPU alone
    }
    mesh.setIndices(render.indices, render.vertexCount);
    mesh.sideOrientation = scene.useRightHandedSystem ? Material.CounterClockWiseSideOrientation
                                                      : Material.ClockWiseSideOrientation;
    this.setMaterials(mesh, render, scene);
    return { mesh, render, positions, normals };
  }

  private setMaterials(mesh: Mesh, render: RenderMesh, scene: Scene): void {
    const materials = render.groups.map(({ material }) => this.materialSet.at(material));
    if (materials.length < 2) {
      mesh.material = materials[0] ?? null;
      return;
    }
    const several = new MultiMaterial(mesh.name, scene);
    several.subMaterials = materials;
    mesh.material = several;
    mesh.subMeshes = [];
    render.groups.forEach(({ start, count }, index) =>
      new SubMesh(index, 0, render.vertexCount, start, count, mesh, mesh, false).setBoundingInfo(mesh.getBoundingInfo()));
  }

  /** Poses the face. `lod`: between its level of detail and the next one, 0 to 1, positions slide continuously. */
  update(controls: Float32Array, lod = 0): void {
    this.posed.pose(controls, lod);
    this.fill();
  }

  private fill(): void {
    const { posed: { bounds }, minimum, maximum } = this;
    minimum.set(bounds[0]!, bounds[1]!, bounds[2]!);
    maximum.set(bounds[3]!, bounds[4]!, bounds[5]!);
    for (const { mesh, render, positions, normals } of this.parts) {
      scatter(render, this.posed.positions, positions);
      scatter(render, this.posed.normals, normals);
      mesh.updateVerticesData(VertexBuffer.PositionKind, positions);
      mesh.updateVerticesData(VertexBuffer.NormalKind, normals);
      const bounding: BoundingInfo = mesh.getBoundingInfo();
      bounding.reConstruct(minimum, maximum, mesh.getWorldMatrix());
    }
  }

  /** Puts the face on a body: joints follow the nodes below `root`, such as the bones of a character, that have their
   * names, by how these move from where they are now. Place the face first. Gives the names of joints without one, which
   * stay with this node. */
  followBones(root: TransformNode): string[] {
    if (!this.skeleton) return [];
    if (!this.followed) this.getScene().onBeforeRenderObservable.add(this.follow);
    this.followed = new FollowedBody(this.skeleton, this.space, root);
    return this.followed.left;
  }

  private readonly follow = (): void => this.followed?.update();

  /** Frees its meshes, materials, textures and skeleton, and takes it out of the scene. The face stays. */
  override dispose(doNotRecurse?: boolean): void {
    if (this.isDisposed()) return;
    this.getScene().onBeforeRenderObservable.removeCallback(this.follow);
    for (const { mesh } of this.parts) {
      if (mesh.material instanceof MultiMaterial) mesh.material.dispose();
      mesh.dispose();
    }
    this.space.dispose();
    this.skeleton?.dispose();
    this.materialSet.dispose();
    super.dispose(doNotRecurse);
  }
}

// What all forms of a face in a scene of three.js have: materials, a skin, a size.
import { Group, Mesh, MeshStandardMaterial, type Bone, type BufferGeometry, type MeshStandardMaterialParameters,
         type Object3D, type Object3DEventMap, type Skeleton, type Texture } from "three";
import type { FaceContents } from "./contents.js";
import type { RenderMesh } from "./render_mesh.js";
import { MaterialSet, loadImage, type LoadTexture } from "./three_materials.js";
import { FaceSkin } from "./three_skin.js";
import { metresPerUnit, scaleToMetres } from "./units.js";

export interface FaceGroupOptions {
  /** Makes textures; by default of what the browser decodes itself. For KTX2 give one that uses KTX2Loader. */
  loadTexture?: LoadTexture;
  /** Whether the face is scaled to metres, which three.js counts in; by default it is in its own `units`. Refused where
   * those are not known. */
  metres?: boolean;
  /** Whether meshes are on the archive's skin, where it has one; true by default. */
  skin?: boolean;
}

export interface FaceGroupEvents extends Object3DEventMap {
  /** A texture has its picture: the scene looks different now. */
  textureload: { texture: Texture };
}

/** A mesh of a character; a SkinnedMesh where it follows joints. */
export type FaceMesh = Mesh<BufferGeometry, MeshStandardMaterial[]>;

/** A group of the meshes of a character. Of faces whose up axis is z it is turned. */
export abstract class FaceGroup extends Group<FaceGroupEvents> {
  /** By material of the face; the last one is for polygons without material. */
  readonly materials: readonly MeshStandardMaterial[];
  /** By joint of the face, in this group; none without a skin. They are at rest until the host moves them. */
  readonly bones: readonly Bone[];
  /** What the meshes are bound to; null without a skin. */
  readonly skeleton: Skeleton | null;
  /** Metres of the unit that positions are in; null where the archive's is not known. */
  readonly metresPerUnit: number | null;
  protected readonly materialSet: MaterialSet;
  protected readonly skin: FaceSkin | null;
  private readonly geometries: BufferGeometry[] = [];

  protected constructor(
      face: FaceContents, options: FaceGroupOptions,
      Material: new (parameters: MeshStandardMaterialParameters) => MeshStandardMaterial = MeshStandardMaterial) {
    super();
    this.name = face.name;
    this.materialSet = new MaterialSet(face, options.loadTexture ?? loadImage,
                                       (texture) => this.dispatchEvent({ type: "textureload", texture }), Material);
    this.materials = this.materialSet.all;
    this.skin = (options.skin ?? true) ? FaceSkin.of(face) : null;
    this.bones = this.skin?.bones ?? [];
    this.skeleton = this.skin?.skeleton ?? null;
    if (this.skin) this.add(...this.skin.roots);
    this.metresPerUnit = metresPerUnit(face.units);
    if (options.metres) this.scale.setScalar(scaleToMetres(face.units));
    if (face.upAxis === "z") this.rotation.x = -Math.PI / 2;
  }

  protected makeMesh(geometry: BufferGeometry, render: RenderMesh, name: string): FaceMesh {
    render.groups.forEach(({ start, count }, index) => geometry.addGroup(start, count, index));
    const materials = render.groups.map(({ material }) => this.materialSet.at(material));
    const mesh = this.skin?.makeMesh(geometry, render, materials) ?? new Mesh(geometry, materials);
    mesh.name = name;
    this.geometries.push(geometry);
    this.add(mesh);
    return mesh;
  }

  /** Puts the face on a body: joints follow the objects below `root`, such as the bones of a character, that have their
   * names, by how these move from where they are now. Place the face first. Gives the names of joints without one, which
   * stay with this group. */
  followBones(root: Object3D): string[] {
    return this.skin?.follow(root) ?? [];
  }

  /** Frees what it has on the GPU, as everywhere in three.js: it stays where it is in the scene, and is sent to the GPU
   * anew where it is drawn again. The face stays. */
  override dispose(): void {
    for (const geometry of this.geometries) geometry.dispose();
    this.skeleton?.dispose();
    this.materialSet.dispose();
  }
}

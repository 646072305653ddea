// The skin of a face as PlayCanvas has it.
import { Entity, Mat4, Quat, Skin, SkinInstance, type AppBase, type GraphNode, type Mesh, type MeshInstance } from "playcanvas";
import type { FaceContents } from "./contents.js";
import { columnsOf } from "./posed_face.js";

const matrixOf = (frame: readonly number[]): Mat4 => new Mat4().set(columnsOf(frame));

function place(bone: Entity, parent: GraphNode, frame: Mat4): void {
  if (bone.parent !== parent) bone.reparent(parent);
  bone.setLocalPosition(frame.getTranslation());
  bone.setLocalRotation(new Quat().setFromMat4(frame));
  bone.setLocalScale(frame.getScale());
}

/** An entity for each joint, in `space`, and the skin of meshes. */
export class PlayCanvasSkin {
  readonly bones: readonly Entity[];
  private readonly skin: Skin;
  private readonly instances: SkinInstance[] = [];

  constructor(face: FaceContents, app: AppBase, private readonly space: Entity) {
    this.bones = face.joints.map(({ name }) => new Entity(name, app));
    face.joints.forEach(({ parent, rest }, index) => place(this.bones[index]!, this.bones[parent] ?? space, matrixOf(rest)));
    this.skin = new Skin(app.graphicsDevice, face.joints.map(({ inverseBind }) => matrixOf(inverseBind)),
                         face.joints.map(({ name }) => name));
  }

  /** Has a mesh follow the bones. */
  carry(mesh: Mesh, instance: MeshInstance): void {
    const followed = new SkinInstance(this.skin);
    followed.bones = [...this.bones];
    mesh.skin = this.skin;
    instance.skinInstance = followed;
    this.instances.push(followed);
    instance.cull = false; // where bones take it is known to the GPU alone
  }

  /** Has bones follow the nodes below `root` that have their names, as these move from where they are now: each becomes
   * a child of that node. Gives the names of the others, which stay in the space of the face. */
  follow(root: GraphNode): string[] {
    const own = new Set<GraphNode>(this.bones), left: string[] = [];
    const worlds = this.bones.map((bone) => bone.getWorldTransform().clone());
    const hosts = this.bones.map(({ name }) => root.findOne((node: GraphNode) => node.name === name && !own.has(node)));
    this.bones.forEach((bone, index) => {
      const host = hosts[index] ?? this.space;
      if (!hosts[index]) left.push(bone.name);
      place(bone, host, host.getWorldTransform().clone().invert().mul(worlds[index]!));
    });
    return left;
  }

  /** Bones may be on a body, which stays. */
  destroy(): void {
    for (const instance of this.instances) instance.destroy();
    for (const bone of this.bones) if (bone.parent) bone.destroy();
  }
}

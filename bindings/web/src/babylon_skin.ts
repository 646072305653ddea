// The skin of a face as Babylon.js has it.
import { Bone } from "@babylonjs/core/Bones/bone.js";
import { Skeleton } from "@babylonjs/core/Bones/skeleton.js";
import { Matrix, Quaternion, Vector3 } from "@babylonjs/core/Maths/math.vector.js";
import { TransformNode } from "@babylonjs/core/Meshes/transformNode.js";
import type { Scene } from "@babylonjs/core/scene.js";
import type { FaceContents } from "./contents.js";
import { columnsOf } from "./posed_face.js";

const matrixOf = (frame: readonly number[]): Matrix => Matrix.FromArray(columnsOf(frame));

/** A bone for each joint, by `index`; parents come before their children. */
export function makeSkeleton(face: FaceContents, scene: Scene): Skeleton {
  const skeleton = new Skeleton(face.name, face.name, scene), made = new Map<number, Bone>();
  const make = (index: number): Bone => {
    const before = made.get(index);
    if (before) return before;
    const { name, parent, rest, inverseBind } = face.joints[index]!;
    const parentBone = parent >= 0 ? make(parent) : null, local = matrixOf(rest);
    // Babylon.js has a bone's place in the bind pose within that of its parent.
    const bind = Matrix.Invert(matrixOf(inverseBind));
    const bindInParent = parentBone ? bind.multiply(matrixOf(face.joints[parent]!.inverseBind)) : bind;
    const bone = new Bone(name, skeleton, parentBone, local, local.clone(), bindInParent, index);
    made.set(index, bone);
    return bone;
  };
  face.joints.forEach((_, index) => make(index));
  return skeleton;
}

/** Bones that follow the nodes of a body. */
export class FollowedBody {
  /** The names of joints that the body has no node for; they stay in the space of the face. */
  readonly left: string[] = [];
  // By bone of the skeleton, parents first: what it follows, and its place in that, or in the space of the face.
  private readonly hosts: (TransformNode | null)[];
  private readonly places: Matrix[];
  private readonly absolutes: Matrix[];
  private readonly toSpace = new Matrix();
  private readonly local = new Matrix();
  private readonly position = new Vector3();
  private readonly rotation = new Quaternion();
  private readonly scaling = new Vector3();

  /** `space`: where positions of the face are. Bones follow the nodes below `root` that have their names, as these move
   * from where they are now. */
  constructor(private readonly skeleton: Skeleton, private readonly space: TransformNode, root: TransformNode) {
    const nodes = root.getDescendants(false).filter((node) => node instanceof TransformNode), world = space.computeWorldMatrix(true);
    skeleton.computeAbsoluteMatrices(true);
    this.hosts = skeleton.bones.map(({ name }) => nodes.find((node) => node.name === name) ?? null);
    this.places = skeleton.bones.map((bone, index) => {
      const host = this.hosts[index], absolute = bone.getAbsoluteMatrix().clone();
      if (host) return absolute.multiply(world).multiply(Matrix.Invert(host.computeWorldMatrix(true)));
      this.left.push(bone.name);
      return absolute;
    });
    this.absolutes = this.places.map(() => new Matrix());
  }

  /** Brings bones to where the nodes are. */
  update(): void {
    const { skeleton: { bones }, hosts, places, absolutes, toSpace, local, position, rotation, scaling } = this;
    this.space.computeWorldMatrix(true).invertToRef(toSpace);
    for (let i = 0; i < bones.length; ++i) {
      const bone = bones[i]!, host = hosts[i], absolute = absolutes[i]!, parent = bone.getParent();
      if (host) places[i]!.multiplyToRef(host.computeWorldMatrix(true), absolute).multiplyToRef(toSpace, absolute);
      else absolute.copyFrom(places[i]!);
      if (parent) {
        absolutes[bones.indexOf(parent)]!.invertToRef(local);
        absolute.multiplyToRef(local, local);
      } else local.copyFrom(absolute);
      local.decompose(scaling, rotation, position);
      bone.scaling = scaling;
      bone.rotationQuaternion = rotation;
      bone.position = position;
    }
  }
}

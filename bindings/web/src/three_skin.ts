// The skin of a face as three.js has it: bones, a skeleton, and what hangs on them.
import {
  Bone, BufferAttribute, Matrix4, PropertyBinding, Skeleton, SkinnedMesh, type BufferGeometry, type Material, type Object3D,
} from "three";
import type { FaceContents, Joint, Skin } from "./contents.js";
import { influenceCount, strongestInfluences } from "./posed_face.js";
import type { RenderMesh } from "./render_mesh.js";

/** A frame of an archive: the upper three rows of a matrix, row after row. */
export function matrixOf(f: ArrayLike<number>, at = 0, to = new Matrix4()): Matrix4 {
  return to.set(f[at]!, f[at + 1]!, f[at + 2]!, f[at + 3]!, f[at + 4]!, f[at + 5]!, f[at + 6]!, f[at + 7]!,
                f[at + 8]!, f[at + 9]!, f[at + 10]!, f[at + 11]!, 0, 0, 0, 1);
}

function makeBone({ name, rest }: Joint): Bone {
  const bone = new Bone();
  bone.name = PropertyBinding.sanitizeNodeName(name); // as GLTFLoader does, for tracks of animations
  bone.userData["name"] = name;
  matrixOf(rest).decompose(bone.position, bone.quaternion, bone.scale);
  return bone;
}

/** Joints that something follows, with weights that sum to 1; none: it stays. */
type Followed = readonly (readonly [joint: number, weight: number])[];

/** Bones and skeleton of a face, one bone a joint. */
export class FaceSkin {
  readonly bones: readonly Bone[];
  readonly skeleton: Skeleton;
  private readonly socketJoints: readonly Followed[];

  private constructor(face: FaceContents, private readonly skin: Skin) {
    this.bones = face.joints.map(makeBone);
    face.joints.forEach(({ parent }, index) => { if (parent >= 0) this.bones[parent]!.add(this.bones[index]!); });
    this.skeleton = new Skeleton([...this.bones], face.joints.map(({ inverseBind }) => matrixOf(inverseBind)));
    this.socketJoints = face.sockets.map(({ vertices, weights }) => this.jointsOf(vertices, weights));
  }

  /** Null of a face that has no skin. */
  static of(face: FaceContents): FaceSkin | null {
    return face.skin && face.joints.length > 0 ? new FaceSkin(face, face.skin) : null;
  }

  /** Bones without a parent among them. */
  get roots(): Bone[] {
    return this.bones.filter(({ parent }) => !parent);
  }

  private jointsOf(vertices: Uint32Array, weights: Float32Array): Followed {
    const { skin } = this, sums = new Map<number, number>();
    vertices.forEach((vertex, k) => {
      for (let i = skin.influences * vertex; i < skin.influences * (vertex + 1); ++i) {
        const weight = weights[k]! * skin.weights[i]!, joint = skin.joints[i]!;
        if (weight !== 0) sums.set(joint, (sums.get(joint) ?? 0) + weight);
      }
    });
    const all = [...sums.values()].reduce((total, weight) => total + weight, 0);
    return all > 0 ? [...sums].map(([joint, weight]) => [joint, weight / all]) : [];
  }

  /** A mesh on the skin; null of one that follows no joint. The four largest weights of a vertex count, as three.js has
   * it. */
  makeMesh<Materials extends Material[]>(geometry: BufferGeometry, render: RenderMesh,
                                         materials: Materials): SkinnedMesh<BufferGeometry, Materials> | null {
    const influences = strongestInfluences(this.skin, render);
    if (!influences) return null;
    geometry.setAttribute("skinIndex", new BufferAttribute(influences.joints, influenceCount));
    geometry.setAttribute("skinWeight", new BufferAttribute(influences.weights, influenceCount));
    const mesh = new SkinnedMesh(geometry, materials);
    mesh.bind(this.skeleton, new Matrix4());
    mesh.frustumCulled = false; // where bones take it is known to the GPU alone
    return mesh;
  }

  /** Has joints follow the objects below `root` that have their names, as these move from where they are now. Gives the
   * names of the joints without one, which stay with the face. */
  follow(root: Object3D): string[] {
    const named = new Map<string, Object3D>();
    root.updateWorldMatrix(true, true);
    root.traverse((object) => { if (object.name) named.set(PropertyBinding.sanitizeNodeName(object.name), object); });
    const left: string[] = [];
    this.bones.forEach((bone, index) => {
      const host = named.get(bone.name) as Bone | undefined;
      if (!host || host === bone) {
        left.push(bone.userData["name"] as string);
        return;
      }
      bone.updateWorldMatrix(true, false);
      const inverse = this.skeleton.boneInverses[index]!, from = this.skeleton.bones[index]!;
      from.updateWorldMatrix(true, false);
      inverse.premultiply(from.matrixWorld).premultiply(host.matrixWorld.clone().invert());
      this.skeleton.bones[index] = host;
    });
    return left;
  }

  /** Where joints take the frame of a socket, in the space of a group whose world matrix that is. */
  carry(socket: number, frame: Matrix4, world: Matrix4, to: Matrix4): void {
    const followed = this.socketJoints[socket]!;
    if (followed.length === 0) {
      to.copy(frame);
      return;
    }
    const { bones, boneInverses } = this.skeleton, moved = new Matrix4(), sum = new Array<number>(16).fill(0);
    for (const [joint, weight] of followed) {
      moved.multiplyMatrices(bones[joint]!.matrixWorld, boneInverses[joint]!);
      for (let i = 0; i < 16; ++i) sum[i]! += weight * moved.elements[i]!;
    }
    to.fromArray(sum).premultiply(moved.copy(world).invert()).multiply(frame);
  }
}

import type { Face } from "facebaker";
import { FaceBakerMesh } from "facebaker/three";
import { Box3, Group, Matrix4, Vector3 } from "three";
import { findMovingPart } from "../app/moving_part";
import { AnalysisMesh } from "./analysis_mesh";
import { computeNormals } from "./polygon_normals";

export type Look = "shaded" | "wireframe" | "normals" | "colours";

/** For faces whose meshes have no material: skin. */
const SKIN = { color: 0xd9a58a, roughness: 0.62 };

/** A face in the scene, upright, its diagonal 1, its middle at the origin; shaded as the archive says, or to be examined. */
export class FaceObject extends Group {
  /** How wide and how high it is at rest, in diagonals. */
  readonly width: number;
  readonly height: number;
  readonly #shaded: FaceBakerMesh;
  #analysis: AnalysisMesh | null = null; // made when first looked at
  #look: Look = "shaded";
  readonly #scaled = new Group();
  #moving: Box3 | null | undefined; // undefined: to be found
  #normals: Float32Array | null = null; // of positions from elsewhere
  /** Called when it looks different by itself: a texture has its picture. */
  changed: () => void = () => {};

  constructor(readonly face: Face) {
    super();
    this.#shaded = new FaceBakerMesh(face, { skin: false }); // its bones would stay at rest
    this.#shaded.addEventListener("textureload", () => this.changed());
    if (face.materials.length === 0) this.#shaded.materials.at(-1)?.setValues(SKIN);
    const size = 1 / (face.diagonal || 1);
    const box = new Box3().setFromArray(face.restPositions);
    this.#scaled.scale.setScalar(size);
    this.#scaled.position.copy(box.getCenter(new Vector3()).multiplyScalar(-size).applyEuler(this.#shaded.rotation));
    this.width = (box.max.x - box.min.x) * size;
    this.height = (face.upAxis === "z" ? box.max.z - box.min.z : box.max.y - box.min.y) * size;
    this.#scaled.add(this.#shaded);
    this.add(this.#scaled);
  }

  /** The box of what its controls move, around its own origin, in diagonals; null where nothing moves. */
  get moving(): Box3 | null {
    if (this.#moving === undefined) this.#moving = this.#findMoving();
    return this.#moving;
  }

  #findMoving(): Box3 | null {
    const part = findMovingPart(this.face);
    if (!part) return null;
    const toObject = new Matrix4().compose(this.#scaled.position, this.#shaded.quaternion, this.#scaled.scale);
    return new Box3(new Vector3(...part.minimum), new Vector3(...part.maximum)).applyMatrix4(toObject);
  }

  /** The mesh whose vertices can be coloured; made now if there was none. */
  get analysis(): AnalysisMesh {
    if (!this.#analysis) {
      this.#analysis = new AnalysisMesh(this.face);
      this.#analysis.visible = false;
      this.#analysis.rotation.copy(this.#shaded.rotation); // the up axis
      this.#scaled.add(this.#analysis);
    }
    return this.#analysis;
  }

  set look(look: Look) {
    this.#look = look;
    this.#shaded.visible = look === "shaded";
    if (look !== "shaded") this.analysis.look = look;
    if (this.#analysis) this.#analysis.visible = look !== "shaded";
  }

  /** Returns the milliseconds that the pose took. */
  pose(controls: Float32Array): number {
    const start = performance.now();
    if (this.#look === "shaded") this.#shaded.update(controls);
    else this.analysis.pose(controls);
    return performance.now() - start;
  }

  /** From the face's own space and units to the scene's. */
  get toScene(): Matrix4 {
    this.#shaded.updateWorldMatrix(true, false);
    return this.#shaded.matrixWorld;
  }

  /** Shows positions from elsewhere in place of a pose. */
  showPositions(positions: Float32Array): void {
    this.#normals ??= new Float32Array(positions.length);
    computeNormals(this.face, positions, this.#normals);
    if (this.#look === "shaded") return this.#shaded.apply({ positions, normals: this.#normals });
    this.analysis.positions.set(positions);
    this.analysis.normals.set(this.#normals);
    this.analysis.touch();
  }

  override dispose(): void {
    this.#shaded.dispose();
    this.#analysis?.dispose();
  }
}

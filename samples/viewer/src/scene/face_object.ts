import type { Face } from "facebaker";
import { FaceBakerMesh } from "facebaker/three";
import { Box3, Group, Vector3 } from "three";
import { AnalysisMesh } from "./analysis_mesh";

export type Look = "shaded" | "wireframe" | "normals" | "colours";

/** A face in the scene, upright, its diagonal 1, its middle at the origin; shaded as the archive says, or to be examined. */
export class FaceObject extends Group {
  /** How wide it is at rest, in diagonals. */
  readonly width: number;
  readonly #shaded: FaceBakerMesh;
  #analysis: AnalysisMesh | null = null; // made when first looked at
  #look: Look = "shaded";
  readonly #turned = new Group();

  constructor(readonly face: Face) {
    super();
    this.#shaded = new FaceBakerMesh(face);
    this.#turned.add(this.#shaded);
    if (face.upAxis === "z") this.#turned.rotation.x = -Math.PI / 2;
    this.#turned.scale.setScalar(1 / (face.diagonal || 1));
    const box = new Box3().setFromArray(face.restPositions);
    const middle = box.getCenter(new Vector3()).multiplyScalar(1 / (face.diagonal || 1)).applyEuler(this.#turned.rotation);
    this.#turned.position.copy(middle).negate();
    this.width = (box.max.x - box.min.x) / (face.diagonal || 1);
    this.add(this.#turned);
  }

  /** The mesh whose vertices can be coloured; made now if there was none. */
  get analysis(): AnalysisMesh {
    if (!this.#analysis) {
      this.#analysis = new AnalysisMesh(this.face);
      this.#analysis.visible = false;
      this.#turned.add(this.#analysis);
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

  override dispose(): void {
    this.removeFromParent();
    this.#shaded.dispose();
    this.#analysis?.dispose();
  }
}

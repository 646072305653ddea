// Driven joints of a face whose vertices a GPU moves.
import { Matrix4 } from "three";
import type { Face } from "./face.js";
import { matrixOf } from "./three_skin.js";

const noMeshes: readonly number[] = [];

/** Finds what the driven joints of a pose do. */
export class DrivenMatrices {
  private readonly frames: Float32Array;
  private readonly inverses: readonly Matrix4[]; // of the frames at rest
  private readonly matrix = new Matrix4();

  /** `to`: as GpuSkin.matrices. */
  constructor(private readonly face: Face, private readonly to: Float32Array) {
    this.frames = new Float32Array(12 * face.drivenJoints.length);
    this.inverses = face.drivenJoints.map(({ rest }) => matrixOf(rest).invert());
  }

  /** Evaluates the numbers of joints, and no vertices. */
  update(controls: Float32Array): void {
    const { face, frames, inverses, matrix, to } = this;
    face.evaluateInto(controls, { joints: frames, meshes: noMeshes });
    inverses.forEach((inverse, joint) => {
      const { elements } = matrixOf(frames, 12 * joint, matrix).multiply(inverse);
      for (let row = 0; row < 3; ++row)
        for (let column = 0; column < 4; ++column)
          to[12 * joint + 4 * row + column] = elements[4 * column + row]! - (row === column ? 1 : 0);
    });
  }
}

// Poses a face and compares every bit with what the native library gave. Runs in Node and in browsers.
import type { Face, Outputs } from "facebaker";
import { firstDifference, type ExpectedPoses } from "./expected_poses.js";

function compare(what: string, found: Float32Array | Uint32Array, expected: Float32Array | Uint32Array): void {
  const at = firstDifference(found, expected);
  if (at >= 0) throw new Error(`${what}: number ${at} is ${found[at]}, expected ${expected[at]}`);
}

/** Throws at the first difference; returns how many poses of how many meshes were compared. */
export function checkSameBits(face: Face, expected: ExpectedPoses): string {
  const { poses } = expected, n = face.controlCount, size = 3 * face.vertexCount;
  const positions = new Float32Array(size), coefficients = new Float32Array(face.coefficientCount);
  for (let p = 0; p < poses; ++p) {
    const controls = expected.controls.subarray(p * n, (p + 1) * n);
    const posed = face.evaluate(controls, positions);
    // Mesh by mesh, so that one that is left out would be noticed.
    for (const mesh of face.meshes) {
      const first = 3 * mesh.firstVertex, last = first + 3 * mesh.vertexCount;
      compare(`pose ${p}, mesh "${mesh.name}"`, posed.subarray(first, last),
              expected.positions.subarray(p * size + first, p * size + last));
    }
    face.coefficients(controls, coefficients);
    compare(`coefficients of pose ${p}`, coefficients,
            expected.coefficients.subarray(p * coefficients.length, (p + 1) * coefficients.length));
  }
  const outputs: Outputs = {};
  const names = ["positions", "normals", "tangents", "bounds", "sockets", "joints", "channels",
                 "expectedErrors"] as const;
  for (const name of names) if (expected[name]) outputs[name] = new Float32Array(expected[name].length);
  if (expected.outside) outputs.outside = new Uint32Array(poses);
  face.evaluateBatch(expected.controls, poses, outputs);
  for (const name of [...names, "outside"] as const)
    if (expected[name]) compare(`${name} of the batch`, outputs[name]!, expected[name]);
  if (expected.unskinned) {
    const { positions } = face.evaluateBatch(expected.controls, poses,
                                             { positions: new Float32Array(poses * size), unskinned: true });
    compare("positions before driven joints", positions, expected.unskinned);
  }
  return `${poses} poses, ${face.meshes.length} meshes, ${face.instructionSet}`;
}

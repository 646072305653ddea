// Where the joints of a face's skin take its vertices when they are turned, computed here, one vertex after the other.
import type { Face } from "facebaker";
import type { PosedVertices } from "./plain_glb.js";

type Matrix = number[]; // 12 numbers: the upper three rows of a 4 x 4 matrix, row after row

function multiply(a: readonly number[], b: readonly number[]): Matrix {
  return Array.from({ length: 12 }, (_, i) => {
    const row = 4 * Math.floor(i / 4), column = i % 4;
    return a[row]! * b[column]! + a[row + 1]! * b[4 + column]! + a[row + 2]! * b[8 + column]! + (column === 3 ? a[row + 3]! : 0);
  });
}

const turnAboutX = (angle: number): Matrix =>
  [1, 0, 0, 0, 0, Math.cos(angle), -Math.sin(angle), 0, 0, Math.sin(angle), Math.cos(angle), 0];

/** An angle for each joint, in steps; null of a face without a skin. */
export function turnsOf(face: Face, step: number): number[] | null {
  return face.skin ? face.joints.map((_, joint) => step * (2 - joint % 3)) : null;
}

/** Moves vertices and normals as facebaker.h says that a skin does. */
export function turnJoints(face: Face, posed: PosedVertices, turns: readonly number[]): PosedVertices {
  const { influences, joints, weights } = face.skin!;
  const places: Matrix[] = [];
  const placeOf = (joint: number): Matrix => {
    const { parent, rest } = face.joints[joint]!, turned = multiply(rest, turnAboutX(turns[joint]!));
    return places[joint] ??= parent < 0 ? turned : multiply(placeOf(parent), turned);
  };
  const moves = face.joints.map(({ inverseBind }, joint) => multiply(placeOf(joint), inverseBind));
  const positions = posed.positions.slice(), normals = posed.normals.slice();
  for (let v = 0; v < face.vertexCount; ++v) {
    const sum = new Array<number>(12).fill(0);
    let all = 0;
    for (let i = influences * v; i < influences * (v + 1); ++i) {
      all += weights[i]!;
      moves[joints[i]!]!.forEach((value, k) => { sum[k]! += weights[i]! * value; });
    }
    if (all === 0) continue;
    const apply = (values: Float32Array, w: number) => [0, 1, 2].map((row) =>
      [0, 1, 2].reduce((total, k) => total + sum[4 * row + k]! * values[3 * v + k]!, w * sum[4 * row + 3]!));
    positions.set(apply(posed.positions, 1), 3 * v);
    const normal = apply(posed.normals, 0), length = Math.hypot(...normal);
    normals.set(normal.map((value) => value / length), 3 * v);
  }
  return { positions, normals };
}

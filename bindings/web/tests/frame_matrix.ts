import { Matrix4 } from "three";

/** A frame of an archive or a pose, the upper three rows of a matrix, which begin at a number. */
export const frame = (numbers: ArrayLike<number>, at = 0): Matrix4 =>
  new Matrix4().fromArray([...Array.from({ length: 12 }, (_, i) => numbers[at + i]!), 0, 0, 0, 1]).transpose();

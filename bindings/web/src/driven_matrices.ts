// What driven joints do, from their frames. Matrices are the upper three rows of a 4 x 4 matrix, row after row.

type Numbers = ArrayLike<number>;

/** The inverse of such a matrix. */
export function inverseOf(m: Numbers): number[] {
  const at = (row: number, column: number) => m[4 * row + column]!;
  const minor = (row: number, column: number) => {
    const [r, s, c, d] = [(row + 1) % 3, (row + 2) % 3, (column + 1) % 3, (column + 2) % 3];
    return at(r, c) * at(s, d) - at(r, d) * at(s, c);
  };
  const determinant = at(0, 0) * minor(0, 0) + at(0, 1) * minor(0, 1) + at(0, 2) * minor(0, 2);
  const inverse = new Array<number>(12);
  for (let row = 0; row < 3; ++row) {
    for (let column = 0; column < 3; ++column) inverse[4 * row + column] = minor(column, row) / determinant;
    inverse[4 * row + 3] = -[0, 1, 2].reduce((sum, k) => sum + inverse[4 * row + k]! * at(k, 3), 0);
  }
  return inverse;
}

/** Replaces the frame at `first` of `frames` by the frame times the inverse of that at rest, less the identity: 0 of one
 * that is where it is at rest. */
export function writeChange(frames: Float32Array, rest: Numbers, inverse: Numbers, first: number): void {
  const frame = frames.slice(first, first + 12);
  if (frame.every((number, i) => number === rest[i])) {
    frames.fill(0, first, first + 12);
    return;
  }
  for (let row = 0; row < 3; ++row) {
    const [x, y, z, origin] = [0, 1, 2, 3].map((column) => frame[4 * row + column]!) as [number, number, number, number];
    for (let column = 0; column < 4; ++column)
      frames[first + 4 * row + column] = x * inverse[column]! + y * inverse[4 + column]! + z * inverse[8 + column]! +
                                         (column === 3 ? origin : row === column ? -1 : 0);
  }
}

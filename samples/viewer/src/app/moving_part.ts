import type { Face } from "facebaker";

/** What a control moves less than this fraction of what moves the farthest does not count. */
const LEAST = 0.1;
const MILLISECONDS = 40; // after which no further controls are looked at
const LEAST_POSES = 16;

/** A box in the rig's own coordinates. */
export interface MovingBox {
  minimum: [number, number, number];
  maximum: [number, number, number];
}

/** Squared distances of vertices from rest: the largest by the ends of single controls. */
function farthestMoves(face: Face): Float32Array {
  const { controls, restControls, restPositions } = face;
  const squares = new Float32Array(face.vertexCount);
  const pose = restControls.slice();
  const look = (index: number, value: number): void => {
    pose[index] = value;
    const posed = face.evaluateInPlace(pose);
    pose[index] = restControls[index];
    for (let v = 0, i = 0; v < squares.length; ++v, i += 3) {
      const x = posed[i] - restPositions[i];
      const y = posed[i + 1] - restPositions[i + 1];
      const z = posed[i + 2] - restPositions[i + 2];
      const square = x * x + y * y + z * z;
      if (square > squares[v]) squares[v] = square;
    }
  };
  // The farther ends first, and controls far apart in the list one after the other: they may not all have their turn.
  const ends = controls.map(({ minimum, maximum, neutral }) =>
    maximum - neutral >= neutral - minimum ? [maximum, minimum] : [minimum, maximum],
  );
  const stride = coprimeStride(controls.length);
  const start = performance.now();
  for (let step = 0; step < 2 * controls.length; ++step) {
    if (step >= LEAST_POSES && performance.now() - start > MILLISECONDS) break;
    const index = (step * stride) % controls.length;
    const end = ends[index][step < controls.length ? 0 : 1];
    if (end !== restControls[index]) look(index, end);
  }
  return squares;
}

/** About 0.62 of count, without a common divisor, so that its multiples visit all. */
function coprimeStride(count: number): number {
  const divisor = (a: number, b: number): number => (b === 0 ? a : divisor(b, a % b));
  let stride = Math.max(1, Math.round(0.618 * count));
  while (divisor(stride, count) > 1) ++stride;
  return stride;
}

/** The box, at rest, of the vertices that single controls move far; null where nothing moves. Takes 40 ms at most, unless
 * the face is large. */
export function findMovingPart(face: Face): MovingBox | null {
  const squares = farthestMoves(face);
  let largest = 0;
  for (const square of squares) if (square > largest) largest = square;
  if (largest === 0) return null;
  const box: MovingBox = { minimum: [Infinity, Infinity, Infinity], maximum: [-Infinity, -Infinity, -Infinity] };
  for (let v = 0; v < squares.length; ++v) {
    if (squares[v] < LEAST * LEAST * largest) continue;
    for (let axis = 0; axis < 3; ++axis) {
      const value = face.restPositions[3 * v + axis];
      if (value < box.minimum[axis]) box.minimum[axis] = value;
      if (value > box.maximum[axis]) box.maximum[axis] = value;
    }
  }
  return box;
}

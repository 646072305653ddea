import type { Face } from "facebaker";

type Vector = readonly [number, number, number];

/** A point of a face's surface: within a triangle of vertices, by weights that sum to 1. */
export interface SurfacePoint {
  vertices: readonly [number, number, number];
  weights: Vector;
}

/** Where a point of the surface is, of positions of all vertices. */
export function positionOf({ vertices, weights }: SurfacePoint, positions: Float32Array): [number, number, number] {
  const at: [number, number, number] = [0, 0, 0];
  vertices.forEach((vertex, corner) => {
    for (let axis = 0; axis < 3; ++axis) at[axis] += weights[corner] * positions[3 * vertex + axis];
  });
  return at;
}

/**
 * Where a ray first meets the surface of a posed face; null where it does not. By Moeller and Trumbore: the triangle's edges
 * and the ray's direction as a base. Back sides count too.
 */
export function pickSurface(face: Face, positions: Float32Array, origin: Vector, direction: Vector): SurfacePoint | null {
  let nearest = Infinity;
  let found: SurfacePoint | null = null;
  const [dx, dy, dz] = direction;
  for (const { triangles } of face.meshes)
    for (let first = 0; first < triangles.length; first += 3) {
      const a = 3 * triangles[first];
      const b = 3 * triangles[first + 1];
      const c = 3 * triangles[first + 2];
      const [ax, ay, az] = [positions[a], positions[a + 1], positions[a + 2]];
      const [ux, uy, uz] = [positions[b] - ax, positions[b + 1] - ay, positions[b + 2] - az];
      const [vx, vy, vz] = [positions[c] - ax, positions[c + 1] - ay, positions[c + 2] - az];
      const [px, py, pz] = [dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx];
      const determinant = ux * px + uy * py + uz * pz;
      if (determinant === 0) continue;
      const [tx, ty, tz] = [origin[0] - ax, origin[1] - ay, origin[2] - az];
      const u = (tx * px + ty * py + tz * pz) / determinant;
      if (u < 0 || u > 1) continue;
      const [qx, qy, qz] = [ty * uz - tz * uy, tz * ux - tx * uz, tx * uy - ty * ux];
      const v = (dx * qx + dy * qy + dz * qz) / determinant;
      if (v < 0 || u + v > 1) continue;
      const distance = (vx * qx + vy * qy + vz * qz) / determinant;
      if (distance <= 0 || distance >= nearest) continue;
      nearest = distance;
      found = {
        vertices: [triangles[first], triangles[first + 1], triangles[first + 2]],
        weights: [1 - u - v, u, v],
      };
    }
  return found;
}

/** Vertices far apart at rest: each the farthest from those before, from the first on. */
export function spreadVertices(positions: Float32Array, count: number): number[] {
  const vertices = positions.length / 3;
  const squares = new Float32Array(vertices).fill(Infinity);
  const chosen: number[] = [];
  for (let next = 0; chosen.length < Math.min(count, vertices); ) {
    chosen.push(next);
    let farthest = 0;
    const from = 3 * next;
    for (let v = 0; v < vertices; ++v) {
      const x = positions[3 * v] - positions[from];
      const y = positions[3 * v + 1] - positions[from + 1];
      const z = positions[3 * v + 2] - positions[from + 2];
      squares[v] = Math.min(squares[v], x * x + y * y + z * z);
      if (squares[v] > squares[farthest]) farthest = v;
    }
    if (squares[farthest] === 0) break;
    next = farthest;
  }
  return chosen;
}

const SYMMETRIC = 0.004; // of the diagonal: how far a mirrored vertex may be from one that is there

/** The middle of a face from left to right, at rest. */
function middleOf(positions: Float32Array): number {
  let least = Infinity;
  let most = -Infinity;
  for (let i = 0; i < positions.length; i += 3) {
    least = Math.min(least, positions[i]);
    most = Math.max(most, positions[i]);
  }
  return (least + most) / 2;
}

/** The point of the surface on the other side of a face that is as good as symmetric in x; null where there is none. */
export function mirrorPoint(face: Face, { vertices, weights }: SurfacePoint): SurfacePoint | null {
  const rest = face.restPositions;
  const middle = middleOf(rest);
  const limit = (SYMMETRIC * face.diagonal) ** 2;
  const mirrored = vertices.map((vertex) => {
    const [x, y, z] = [2 * middle - rest[3 * vertex], rest[3 * vertex + 1], rest[3 * vertex + 2]];
    let best = -1;
    let least = limit;
    for (let v = 0; v < rest.length / 3; ++v) {
      const square = (rest[3 * v] - x) ** 2 + (rest[3 * v + 1] - y) ** 2 + (rest[3 * v + 2] - z) ** 2;
      if (square > least) continue;
      least = square;
      best = v;
    }
    return best;
  });
  if (mirrored.includes(-1)) return null;
  return { vertices: [mirrored[0], mirrored[1], mirrored[2]], weights };
}

import type { Face } from "facebaker";

/** Normals of vertices whose positions come from elsewhere, as the runtime has them of its own: a vertex's is that of the
 * sum of the area vectors of the polygons around it. */
export function computeNormals(face: Face, positions: Float32Array, normals: Float32Array): void {
  normals.fill(0);
  for (const { polygonSizes, polygonCorners } of face.meshes) {
    let first = 0;
    for (const size of polygonSizes) {
      addArea(polygonCorners, first, size, positions, normals);
      first += size;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]);
    if (length === 0) continue;
    for (let axis = 0; axis < 3; ++axis) normals[i + axis] /= length;
  }
}

/** Adds the area vector of a polygon to those of its corners. */
function addArea(corners: Uint32Array, first: number, size: number, positions: Float32Array, normals: Float32Array): void {
  const origin = 3 * corners[first];
  const [ox, oy, oz] = [positions[origin], positions[origin + 1], positions[origin + 2]];
  let [ax, ay, az] = [0, 0, 0];
  for (let k = first + 1; k + 1 < first + size; ++k) {
    const b = 3 * corners[k];
    const c = 3 * corners[k + 1];
    const [bx, by, bz] = [positions[b] - ox, positions[b + 1] - oy, positions[b + 2] - oz];
    const [cx, cy, cz] = [positions[c] - ox, positions[c + 1] - oy, positions[c + 2] - oz];
    ax += by * cz - bz * cy;
    ay += bz * cx - bx * cz;
    az += bx * cy - by * cx;
  }
  for (let k = first; k < first + size; ++k) {
    const v = 3 * corners[k];
    normals[v] += ax;
    normals[v + 1] += ay;
    normals[v + 2] += az;
  }
}

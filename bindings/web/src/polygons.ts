/** Cuts polygons into triangles, fans of their first corners: for each triangle three of `corners`. */
export function fanTriangles(sizes: Uint32Array, corners: Uint32Array): Uint32Array {
  const triangles = new Uint32Array(3 * (corners.length - 2 * sizes.length));
  let first = 0, at = 0;
  for (const size of sizes) {
    for (let k = 1; k + 1 < size; ++k) {
      triangles[at++] = corners[first]!;
      triangles[at++] = corners[first + k]!;
      triangles[at++] = corners[first + k + 1]!;
    }
    first += size;
  }
  return triangles;
}

/** Distances of vertices from where they should be. */
export interface VertexErrors {
  /** One a vertex, in the rig's unit. */
  distances: Float32Array;
  rms: number;
  max: number;
  worst: number;
}

/** `positions`, `truth`: 3 floats a vertex. `into`: a buffer of one float a vertex. */
export function measureErrors(positions: Float32Array, truth: Float32Array, into: Float32Array): VertexErrors {
  let squares = 0;
  let max = 0;
  let worst = 0;
  for (let v = 0; v < into.length; ++v) {
    const x = positions[3 * v] - truth[3 * v];
    const y = positions[3 * v + 1] - truth[3 * v + 1];
    const z = positions[3 * v + 2] - truth[3 * v + 2];
    const square = x * x + y * y + z * z;
    squares += square;
    into[v] = Math.sqrt(square);
    if (into[v] > max) {
      max = into[v];
      worst = v;
    }
  }
  return { distances: into, rms: Math.sqrt(squares / Math.max(into.length, 1)), max, worst };
}

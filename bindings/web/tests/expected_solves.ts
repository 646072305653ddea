// What native_solves.c dumped: poses with derivatives, and the controls that the native library found for them.

export interface ExpectedSolve {
  pose: Float32Array;
  /** Of what is followed; the points of them are the targets. */
  values: Float32Array;
  derivatives: Float32Array;
  found: Float32Array;
  decided: Float32Array;
  differences: Float32Array;
  /** Iterations, whether it converged, points, the worst of them. */
  counts: number[];
  distances: number[];
  objective: number;
}

export interface ExpectedSolves {
  vertices: Uint32Array;
  sockets: number;
  joints: number;
  solves: ExpectedSolve[];
}

export function readExpectedSolves(buffer: ArrayBuffer): ExpectedSolves {
  const view = new DataView(buffer);
  const [solves, controls, points, rows, sockets, joints] =
    new Uint32Array(buffer, 0, 6) as unknown as [number, number, number, number, number, number];
  let at = 24;
  const floats = (count: number) => {
    const array = new Float32Array(buffer, at, count);
    at += array.byteLength;
    return array;
  };
  const vertices = new Uint32Array(buffer, at, 3 * points).filter((_, i) => i % 3 === 0);
  at += 12 * points;
  const all = Array.from({ length: solves }, (): ExpectedSolve => {
    const pose = floats(controls), values = floats(rows), derivatives = floats(rows * controls);
    const found = floats(controls), decided = floats(controls), differences = floats(points);
    const counts = [0, 4, 8, 12].map((offset) => view.getUint32(at + offset, true));
    at += 16;
    const distances = [...floats(2)], objective = view.getFloat64(at, true);
    at += 8;
    return { pose, values, derivatives, found, decided, differences, counts, distances, objective };
  });
  return { vertices, sockets, joints, solves: all };
}

// What native_poses.c dumped: poses, and all that the native library evaluated of them.

export interface ExpectedPoses {
  poses: number;
  controls: Float32Array;
  positions: Float32Array;
  normals: Float32Array;
  tangents?: Float32Array;
  coefficients: Float32Array;
  bounds: Float32Array;
  sockets?: Float32Array;
  channels?: Float32Array;
  expectedErrors?: Float32Array;
  outside?: Uint32Array;
  /** Frames of driven joints, and positions before these move vertices. */
  joints?: Float32Array;
  unskinned?: Float32Array;
}

export function readExpectedPoses(buffer: ArrayBuffer): ExpectedPoses {
  const header = new Uint32Array(buffer, 0, 9);
  const [poses, controls, vertices, coefficients, sockets, channels, errors, hasUvs, joints] =
    header as unknown as [number, number, number, number, number, number, number, number, number];
  let at = header.byteLength;
  const floats = (count: number) => {
    const array = new Float32Array(buffer, at, poses * count);
    at += array.byteLength;
    return array;
  };
  const read: ExpectedPoses = {
    poses, controls: floats(controls), positions: floats(3 * vertices), normals: floats(3 * vertices),
    ...(hasUvs ? { tangents: floats(3 * vertices) } : {}),
    coefficients: floats(coefficients), bounds: floats(6),
  };
  if (sockets) read.sockets = floats(12 * sockets);
  if (channels) read.channels = floats(channels);
  if (errors) {
    read.expectedErrors = floats(errors);
    read.outside = new Uint32Array(buffer, at, poses);
    at += read.outside.byteLength;
  }
  if (joints) {
    read.joints = floats(12 * joints);
    read.unskinned = floats(3 * vertices);
  }
  return read;
}

/** Where the bits of two arrays differ first; -1 if they are the same. */
export function firstDifference(a: Float32Array | Uint32Array, b: Float32Array | Uint32Array): number {
  if (a.length !== b.length) return Math.min(a.length, b.length);
  const x = new Uint32Array(a.buffer, a.byteOffset, a.length), y = new Uint32Array(b.buffer, b.byteOffset, b.length);
  for (let i = 0; i < x.length; ++i) if (x[i] !== y[i]) return i;
  return -1;
}

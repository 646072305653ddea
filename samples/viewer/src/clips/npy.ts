import { ClipError } from "./clip";

export interface NpyArray {
  shape: number[];
  values: Float32Array;
}

const READERS: Record<string, (view: DataView, at: number) => number> = {
  "<f4": (view, at) => view.getFloat32(at, true),
  "<f8": (view, at) => view.getFloat64(at, true),
  "<i4": (view, at) => view.getInt32(at, true),
  "<i8": (view, at) => Number(view.getBigInt64(at, true)),
};

/** Reads a NumPy file, version 1 or 2, of little-endian numbers in C order. `name` stands for it in messages. */
export function parseNpy(bytes: ArrayBuffer, name: string): NpyArray {
  const refuse = (reason: string): never => {
    throw new ClipError(`${name}: ${reason}`);
  };
  const view = new DataView(bytes);
  const magic = bytes.byteLength >= 12 && view.getUint8(0) === 0x93 && view.getUint32(1) === 0x4e554d50 && view.getUint8(5) === 0x59;
  const version = magic ? view.getUint8(6) : 0;
  if (version !== 1 && version !== 2) refuse("this is no NumPy file of version 1 or 2");
  const start = version === 1 ? 10 : 12;
  const length = version === 1 ? view.getUint16(8, true) : view.getUint32(8, true);
  if (start + length > bytes.byteLength) refuse("the file ends within its header");
  const header = new TextDecoder("latin1").decode(new Uint8Array(bytes, start, length));
  const type = /'descr':\s*'([^']*)'/.exec(header)?.[1] ?? "";
  const shapeText = /'shape':\s*\(([^)]*)\)/.exec(header)?.[1];
  if (!/'fortran_order':\s*False/.test(header) || shapeText === undefined) refuse("it is not in C order, or has no shape");
  const shape = (shapeText ?? "").split(",").map((side) => side.trim()).filter((side) => side !== "").map(Number);
  const read = READERS[type];
  if (read === undefined) refuse(`holds numbers of type '${type}'; read are little-endian <f4, <f8, <i4 and <i8`);
  const count = shape.reduce((all, side) => all * side, 1);
  const size = Number(type.slice(2));
  if (!Number.isSafeInteger(count) || start + length + count * size !== bytes.byteLength)
    refuse(`has ${bytes.byteLength - start - length} bytes of values where its shape says ${count * size}`);
  if (type === "<f4") return { shape, values: new Float32Array(bytes.slice(start + length)) };
  const values = new Float32Array(count);
  for (let i = 0, at = start + length; i < count; ++i, at += size) values[i] = read(view, at);
  return { shape, values };
}

/** Controls of frames; refused unless they are as wide as the face. */
export function controlsOf(array: NpyArray, controlCount: number, name: string): { frames: number; controls: Float32Array } {
  const [frames, width] = array.shape;
  if (array.shape.length !== 2 || width !== controlCount || frames === 0)
    throw new ClipError(
      `${name}: has the shape ${array.shape.join(" x ")}, where a clip of this face is frames x ${controlCount} controls`,
    );
  if (!array.values.every(Number.isFinite)) throw new ClipError(`${name}: holds a value that is no finite number`);
  return { frames, controls: array.values };
}

/** A NumPy file of floats in C order. */
export function writeNpy(values: Float32Array, shape: readonly number[]): Uint8Array<ArrayBuffer> {
  const header = `{'descr': '<f4', 'fortran_order': False, 'shape': (${shape.join(", ")}), }`;
  const start = 64 * Math.ceil((10 + header.length + 1) / 64);
  const bytes = new Uint8Array(start + 4 * values.length);
  bytes.set([0x93, ...new TextEncoder().encode("NUMPY"), 1, 0]);
  bytes.set(new TextEncoder().encode(`${header.padEnd(start - 11)}\n`), 10);
  const view = new DataView(bytes.buffer);
  view.setUint16(8, start - 10, true);
  values.forEach((value, i) => view.setFloat32(start + 4 * i, value, true));
  return bytes;
}

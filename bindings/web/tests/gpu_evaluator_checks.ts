// Poses that GpuEvaluator has a GPU compute, compared bit for bit with the processor's. Runs in Node and in browsers.
import type { Face } from "facebaker";
import { GpuEvaluator, type GpuEvaluatorOptions, type GpuPoseOptions } from "facebaker/webgpu";

const readUse = 9; // MAP_READ, COPY_DST

/** What lies in a buffer, from a byte on. */
export async function readBuffer(device: GPUDevice, from: GPUBuffer, offset: number, size: number): Promise<Uint32Array> {
  const read = device.createBuffer({ size, usage: readUse });
  const encoder = device.createCommandEncoder();
  encoder.copyBufferToBuffer(from, offset, read, 0, size);
  device.queue.submit([encoder.finish()]);
  await read.mapAsync(1);
  const words = new Uint32Array(read.getMappedRange().slice(0));
  read.destroy();
  return words;
}

/** Poses of all controls and of a fifth of them, some beyond their ranges, the same for the same seed; the first is at
 * rest, the last ones are the exact poses. */
export function drawPoses(face: Face, count: number, seed = 1): Float32Array {
  const n = face.controlCount, drawn = new Float32Array(count * n);
  let random = seed >>> 0;
  const draw = () => (random = (Math.imul(random, 1664525) + 1013904223) >>> 0) / 2 ** 32;
  for (let pose = 0; pose < count; ++pose)
    for (const { index, minimum, maximum, neutral } of face.controls) {
      const value = draw() * (pose % 8 === 7 ? 1.5 : 1), rests = pose === 0 || (pose % 2 === 1 && draw() > 0.2);
      drawn[pose * n + index] = rests ? neutral : minimum + value * (maximum - minimum);
    }
  face.exactPoses.forEach(({ controls }, i) => drawn.set(controls, Math.max(0, count - 1 - i) * n));
  return drawn;
}

const isNaNBits = (bits: number): boolean => (bits & 0x7fffffff) > 0x7f800000;

/** Whether bits are other ones: NaN has many. */
export const differs = (found: number, expected: number): boolean =>
  found !== expected && !(isNaNBits(found) && isNaNBits(expected));

/** Numbers whose bits differ. */
export function countDifferent(found: Uint32Array, expected: Float32Array): number {
  const bits = new Uint32Array(expected.buffer, expected.byteOffset, expected.length);
  let different = Math.abs(found.length - bits.length);
  for (let i = 0; i < Math.min(found.length, bits.length); ++i) if (differs(found[i]!, bits[i]!)) ++different;
  return different;
}

/** The largest distance of a number from the other's, over the diagonal; of what is finite. */
export function farthest(face: Face, found: Uint32Array, expected: Float32Array): number {
  const floats = new Float32Array(found.buffer);
  let most = 0;
  for (let i = 0; i < floats.length; ++i)
    if (Number.isFinite(expected[i])) most = Math.max(most, Math.abs(floats[i]! - expected[i]!) || 0);
  return most / face.diagonal;
}

/** Evaluates poses on both. Throws where bits differ, after driven joints those of a first pose at rest; returns how far skinned positions are apart, over the diagonal. */
export async function checkGpuEvaluator(device: GPUDevice, face: Face, controls: Float32Array, poses: number,
                                        options: GpuEvaluatorOptions = {}): Promise<number> {
  const vertexOrder = options.vertexOrder ?? "source", size = 3 * face.vertexCount;
  const evaluator = new GpuEvaluator(device, face, options), offset = 20;
  const buffer = device.createBuffer({ size: offset + evaluator.bytesOf(poses) + 8, usage: 128 | 4 });
  let skinned = 0;
  try {
    for (const asked of [{ unskinned: true }, { displacements: true }, {}] as GpuPoseOptions[]) {
      evaluator.evaluate(controls, poses, buffer, { ...asked, offset });
      const found = await readBuffer(device, buffer, offset, evaluator.bytesOf(poses));
      const { positions } = face.evaluateBatch(controls, poses,
                                               { positions: new Float32Array(poses * size), vertexOrder, ...asked });
      if (asked.unskinned || asked.displacements || !face.drivenSkin) {
        const different = countDifferent(found, positions);
        if (different > 0) throw new Error(`${different} of ${positions.length} numbers differ (${JSON.stringify(asked)})`);
      } else {
        skinned = farthest(face, found, positions);
        const rest = face.evaluateBatch(controls, 1, { positions: new Float32Array(size), vertexOrder }).positions;
        const still = controls.subarray(0, face.controlCount).every((value, i) => value === face.restControls[i]);
        if (still && countDifferent(found.subarray(0, size), rest) > 0) throw new Error("the rest mesh differs");
      }
    }
    const around = await readBuffer(device, buffer, 0, offset);
    if (around.some((word) => word !== 0)) throw new Error("numbers before the positions were written");
  } finally {
    evaluator.dispose();
    buffer.destroy();
  }
  return skinned;
}

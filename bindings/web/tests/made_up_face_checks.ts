// A face that is made up of what archives seldom have: row blocks of several panels, which split vertices, sums near 32
// bits, steps of any size, rest positions of -0, corrections.
import type { Face, RowBlock } from "facebaker";
import { GpuEvaluator } from "facebaker/webgpu";
import type { QuantisedOutputs } from "../dist/quantised_poses.js";
import { countDifferent, readBuffer } from "./gpu_evaluator_checks.js";

const rowCounts = [1, 193, 200, 400, 191, 2, 576, 48], columnCounts = [3, 9, 1, 0, 130, 4, 5, 7];
const rows = rowCounts.reduce((sum, count) => sum + count, 0), columns = columnCounts.reduce((sum, count) => sum + count, 0);

let random = 5;
const draw = (): number => (random = (Math.imul(random, 1664525) + 1013904223) >>> 0) / 2 ** 32;
const drawWhole = (least: number, most: number): number => Math.floor(least + draw() * (most - least + 1));

function makeBlocks(): RowBlock[] {
  let firstRow = 0;
  return rowCounts.map((rowCount, b) => {
    const count = columnCounts[b]!, digits = new Int8Array(count * rowCount);
    // Of any width, group by group.
    for (let i = 0, most = 127; i < digits.length; ++i) {
      if (i % 29 === 0) most = [0, 0, 1, 7, 127][drawWhole(0, 4)]!;
      digits[i] = drawWhole(-most - 1, most) * Number(most > 0);
    }
    const block = { firstRow, rowCount, columns: Uint32Array.from({ length: count }, (_, i) => i),
                    scales: new Float32Array(count).fill(1), digits };
    firstRow += rowCount;
    return block;
  });
}

function makePoses(count: number): Required<Omit<QuantisedOutputs, "joints">> {
  const steps = new Float32Array(count * rowCounts.length), quantised = new Int16Array(count * columns);
  for (let i = 0; i < steps.length; ++i) steps[i] = draw() < 0.2 ? 0 : 2 ** drawWhole(-110, 100) * (1 + draw());
  for (let i = 0; i < quantised.length; ++i) quantised[i] = draw() < 0.4 ? 0 : drawWhole(-32512, 32512);
  return { steps, quantised, exactWeights: Float32Array.from({ length: 2 * count }, () => Math.max(0, draw() - 0.3)) };
}

// As EVALUATION.md has it: JavaScript rounds to 64 bits, Math.fround to 32.
function pose(face: Face, poses: ReturnType<typeof makePoses>, index: number): Float32Array {
  const positions = new Float32Array(rows), rest = face.restPositions, order = face.vertexOrder!;
  let column = index * columns;
  face.rowBlocks.forEach(({ firstRow, rowCount, columns: of, digits }, b) => {
    const step = poses.steps[index * rowCounts.length + b]!;
    for (let r = 0; r < rowCount; ++r) {
      const row = firstRow + r, at = 3 * order[Math.floor(row / 3)]! + (row % 3);
      let sum = 0;
      for (let c = 0; c < of.length; ++c) sum += poses.quantised[column + c]! * digits[c * rowCount + r]!;
      positions[at] = step === 0 ? rest[at]! : rest[at]! + Math.fround(step * Math.fround(sum));
      face.exactCorrections.forEach((blocks, e) => {
        const weight = poses.exactWeights[2 * index + e]!, corrections = blocks[b];
        if (weight !== 0 && corrections) positions[at] = positions[at]! + Math.fround(weight * corrections[r]!);
      });
    }
    column += of.length;
  });
  return positions;
}

/** Throws where positions differ; returns how many numbers are the same. */
export async function checkMadeUpFace(device: GPUDevice): Promise<number> {
  const count = 21, poses = makePoses(count), vertexCount = rows / 3;
  const face = {
    vertexCount, controlCount: 1, rowBlocks: makeBlocks(), exactPoses: [{}, {}], drivenJoints: [], drivenSkin: null,
    vertexOrder: Uint32Array.from({ length: vertexCount }, (_, i) => (i * 7) % vertexCount),
    restPositions: Float32Array.from({ length: rows }, (_, i) => (i % 5 === 0 ? -0 : 2 ** drawWhole(-30, 30) * (draw() - 0.5))),
    exactCorrections: [0, 1].map((e) => rowCounts.map((size, b) =>
      (b + e) % 3 === 0 ? null : Float32Array.from({ length: size }, (_, r) => (r % 4 === 0 ? 0 : draw() - 0.5)))),
    quantise: (controls: Float32Array, asked: number, outputs: ReturnType<typeof makePoses>) => {
      const first = controls[0]!; // the number of the pose
      outputs.quantised.set(poses.quantised.subarray(first * columns, (first + asked) * columns));
      outputs.steps.set(poses.steps.subarray(first * rowCounts.length, (first + asked) * rowCounts.length));
      outputs.exactWeights.set(poses.exactWeights.subarray(2 * first, 2 * (first + asked)));
    },
  } as unknown as Face;
  const evaluator = new GpuEvaluator(device, face, { limits: { maxComputeWorkgroupsPerDimension: 3 } });
  const buffer = evaluator.createBuffer(count);
  evaluator.evaluate(Float32Array.from({ length: count }, (_, i) => i), count, buffer);
  const found = await readBuffer(device, buffer, 0, evaluator.bytesOf(count));
  for (let index = 0; index < count; ++index) {
    const different = countDifferent(found.subarray(index * rows, (index + 1) * rows), pose(face, poses, index));
    if (different > 0) throw new Error(`pose ${index} of the made-up face: ${different} numbers differ`);
  }
  evaluator.dispose();
  buffer.destroy();
  return found.length;
}

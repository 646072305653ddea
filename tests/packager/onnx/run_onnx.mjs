// Compares an exported ONNX model in ONNX Runtime with the evaluator's positions, a point cache of the same poses:
//   node run_onnx.mjs FACE.onnx POSES.npy POSES.mdd
// Fails unless every vertex of every pose is within 1e-5 of the diagonal, and without graph optimisation where it was
// evaluated, to the last bit.
import fs from "node:fs";
import ort from "onnxruntime-node";

const block = 16; // poses a call
const [model, npy, mdd] = process.argv.slice(2);

function readNpy(file) {
  const bytes = fs.readFileSync(file);
  const header = bytes.readUInt16LE(8);
  const [, rows, columns] = /'shape': \((\d+), (\d+)\)/.exec(bytes.toString("latin1", 10, 10 + header)).map(Number);
  const data = bytes.buffer.slice(bytes.byteOffset + 10 + header, bytes.byteOffset + bytes.length);
  return { rows, columns, values: new Float32Array(data) };
}

function readMdd(file) {
  const bytes = fs.readFileSync(file);
  const frames = bytes.readInt32BE(0), points = bytes.readInt32BE(4), values = new Float32Array(3 * frames * points);
  for (let i = 0; i < values.length; ++i) values[i] = bytes.readFloatBE(8 + 4 * frames + 4 * i);
  return { frames, points, values };
}

const poses = readNpy(npy), expected = readMdd(mdd), size = 3 * expected.points;
const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
for (let i = 0; i < size; ++i) { // of the first pose, which is at rest
  low[i % 3] = Math.min(low[i % 3], expected.values[i]);
  high[i % 3] = Math.max(high[i % 3], expected.values[i]);
}
const diagonal = Math.hypot(...high.map((h, i) => h - low[i]));

// The largest distance of all poses, over the diagonal.
async function measure(optimisation) {
  const started = performance.now();
  const session = await ort.InferenceSession.create(model, { intraOpNumThreads: 1, interOpNumThreads: 1,
    graphOptimizationLevel: optimisation });
  const opened = performance.now() - started;
  let largest = 0, worst = 0, squares = 0, milliseconds = 0;
  for (let first = 0; first < poses.rows; first += block) {
    const count = Math.min(block, poses.rows - first);
    const controls = poses.values.slice(first * poses.columns, (first + count) * poses.columns);
    const begun = performance.now();
    const { positions } = await session.run({ controls: new ort.Tensor("float32", controls, [count, poses.columns]) });
    milliseconds += performance.now() - begun;
    if (String(positions.dims) !== String([count, expected.points, 3])) throw new Error(`positions are ${positions.dims}`);
    for (let v = 0; v < count * expected.points; ++v) {
      const at = first * size + 3 * v;
      const off = Math.hypot(...[0, 1, 2].map((k) => positions.data[3 * v + k] - expected.values[at + k]));
      if (!Number.isFinite(off)) throw new Error(`pose ${first + Math.floor(v / expected.points)} is not finite`);
      squares += off * off;
      if (off > largest) [largest, worst] = [off, first + Math.floor(v / expected.points)];
    }
  }
  const rms = Math.sqrt(squares / (poses.rows * expected.points));
  console.log(`${model}, graph optimisation ${optimisation}: ${poses.rows} poses, off by at most ` +
    `${(largest / diagonal).toExponential(1)} of the diagonal (pose ${worst}), rms ${(rms / diagonal).toExponential(1)}; ` +
    `opened in ${opened.toFixed(0)} ms, ${(milliseconds / poses.rows).toFixed(2)} ms a pose in blocks of ${block}`);
  return largest / diagonal;
}

if (!((await measure("all")) <= 1e-5)) {
  console.error("more than 1e-5 of the diagonal");
  process.exit(1);
}
if ((await measure("disabled")) !== 0) {
  console.error("not the evaluator's bits");
  process.exit(1);
}

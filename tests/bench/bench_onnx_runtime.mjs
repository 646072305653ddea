// Measures the paper's network, 8 layers of 256, relu, skips, 200 components and a dense basis, in ONNX Runtime on one
// thread, taking turns with `facebaker bench`. Prints medians, microseconds of processor time a pose. See
// bench_onnx_runtime.sh.
import { spawnSync } from "node:child_process";
import { readFileSync, rmSync } from "node:fs";
import os from "node:os";
import path from "node:path";
import ort from "onnxruntime-node";

const depth = 8, width = 256, components = 200, batch = 256, rounds = 3;

// Protocol buffers: a field is its number and kind, then a number, or bytes and their count.
const varint = (n) => (n < 128 ? [n] : [(n % 128) + 128, ...varint(Math.floor(n / 128))]);
const number = (field, n) => Buffer.from([...varint(field * 8), ...varint(n)]);
const bytes = (field, b) => {
  const content = Buffer.isBuffer(b) ? b : Buffer.from(b);
  return Buffer.concat([Buffer.from([...varint(field * 8 + 2), ...varint(content.length)]), content]);
};
const message = (...fields) => Buffer.concat(fields);

// The messages of ONNX that a network of dense layers needs.
const float32 = 1;
const tensor = (name, dims, floats) =>
  message(...dims.map((d) => number(1, d)), number(2, float32), bytes(8, name), bytes(9, Buffer.from(floats.buffer)));
const node = (type, inputs, output) =>
  message(...inputs.map((i) => bytes(1, i)), bytes(2, output), bytes(3, output), bytes(4, type));
const value = (name, dims) => {
  const shape = message(...dims.map((d) => bytes(1, number(1, d))));
  return message(bytes(1, name), bytes(2, bytes(1, message(number(1, float32), bytes(2, shape)))));
};
const model = (nodes, initializers, inputs, outputs) =>
  message(number(1, 8), bytes(7, message(...nodes.map((n) => bytes(1, n)), bytes(2, "paper"),
    ...initializers.map((t) => bytes(5, t)), ...inputs.map((v) => bytes(11, v)), ...outputs.map((v) => bytes(12, v)))),
    bytes(8, number(2, 13)));

function paperNetwork(controls, vertices, poses) {
  const nodes = [], initializers = [];
  let x = "controls";
  const sizes = [controls, ...Array(depth).fill(width), components, 3 * vertices];
  for (let l = 0; l + 1 < sizes.length; ++l) {
    const [inputs, outputs] = [sizes[l], sizes[l + 1]];
    const reach = Math.sqrt(3 / inputs);
    const weights = Float32Array.from({ length: inputs * outputs }, () => (2 * Math.random() - 1) * reach);
    initializers.push(tensor(`w${l}`, [inputs, outputs], weights), tensor(`b${l}`, [outputs], new Float32Array(outputs)));
    const last = l + 2 === sizes.length;
    nodes.push(node("Gemm", [x, `w${l}`, `b${l}`], last ? "positions" : `y${l}`));
    if (l < depth) nodes.push(node("Relu", [`y${l}`], `r${l}`));
    if (l > 0 && l < depth) nodes.push(node("Add", [`r${l}`, x], `x${l}`));
    x = l === 0 ? "r0" : l < depth ? `x${l}` : `y${l}`;
  }
  return model(nodes, initializers, [value("controls", [poses, controls])], [value("positions", [poses, 3 * vertices])]);
}

const median = (times) => times.sort((a, b) => a - b)[times.length >> 1];

// Medians of `count` calls of a session with its own input and output, in microseconds a pose.
async function prepare(file, poses, inputs, outputs) {
  const session = await ort.InferenceSession.create(file, { intraOpNumThreads: 1, interOpNumThreads: 1 });
  const controls = Float32Array.from({ length: poses * inputs }, Math.random);
  const feeds = { controls: new ort.Tensor("float32", controls, [poses, inputs]) };
  const fetches = { positions: new ort.Tensor("float32", new Float32Array(poses * outputs), [poses, outputs]) };
  return async (count) => {
    const times = [];
    for (let i = 0; i < count + 2; ++i) {
      const start = process.cpuUsage();
      await session.run(feeds, fetches);
      const { user, system } = process.cpuUsage(start);
      if (i >= 2) times.push((user + system) / poses);
    }
    return median(times);
  };
}

const [tool, archive, ...source] = process.argv.slice(2);
const described = JSON.parse(spawnSync(tool, ["inspect", "--json", archive], { maxBuffer: 1 << 28 }).stdout);
const [controls, vertices] = [described.controls, described.vertices].map((n) => (Array.isArray(n) ? n.length : n));
const nothing = await prepare(model([node("Relu", ["controls"], "positions")], [], [value("controls", [1, 1])],
  [value("positions", [1, 1])]), 1, 1, 1);
const one = await prepare(paperNetwork(controls, vertices, 1), 1, controls, 3 * vertices);
const many = await prepare(paperNetwork(controls, vertices, batch), batch, controls, 3 * vertices);

const json = path.join(os.tmpdir(), `bench_onnx_runtime_${process.pid}.json`);
const figures = {};
const add = (name, time) => (figures[name] ??= []).push(time);
for (let round = 0; round < rounds; ++round) {
  add("a call of ONNX Runtime", await nothing(400));
  add("paper's network, ONNX Runtime", await one(400));
  add(`batch of ${batch}: paper's network, ONNX Runtime`, await many(8));
  const run = spawnSync(tool, ["bench", archive, "--json", json, ...source.flatMap((s) => ["--source", s])]);
  if (run.status !== 0) throw new Error(String(run.stderr));
  for (const { name, median_us } of JSON.parse(readFileSync(json)).lines) add(name, median_us);
}
rmSync(json);

const figure = (name) => median([...figures[name]]);
const print = (name, beside) => {
  const ratio = beside ? (figure(beside) / figure(name)).toFixed(1) : "";
  console.log(`| ${name.padEnd(48)} | ${figure(name).toFixed(1).padStart(8)} | ${ratio.padStart(14)} |`);
};
console.log(`onnxruntime-node ${ort.env.versions.node}, one thread; medians of ${rounds} turns`);
console.log(`| ${"microseconds a pose".padEnd(48)} |   median | times as quick |`);
console.log(`| ${"-".repeat(48)} | -------: | -------------: |`);
const single = "paper's network, ONNX Runtime", batched = `batch of ${batch}: ${single}`;
print("a call of ONNX Runtime");
print(single);
print("paper's network, Eigen", single);
print("positions", single);
print("positions, baked order", single);
print(batched);
print(`batch of ${batch}: paper's network, Eigen`, batched);
print(`batch of ${batch}: positions`, batched);

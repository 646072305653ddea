// The shader's arithmetic with the bits of floats, compared with the processor's.
import { exactArithmetic } from "../dist/exact_arithmetic_shader.js";
import { countDifferent, differs, readBuffer } from "./gpu_evaluator_checks.js";

const code = `
@group(0) @binding(0) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> results: array<u32>;
${exactArithmetic}
@compute @workgroup_size(64)
fn compute(@builtin(global_invocation_id) thread: vec3<u32>) {
  let pair = pairs[thread.x];
  results[3u * thread.x] = multiplied(pair.x, pair.y);
  results[3u * thread.x + 1u] = added(pair.x, pair.y);
  results[3u * thread.x + 2u] = float_of(bitcast<i32>(pair.x));
}
`;

// Where roundings and cases change.
const corners = [0, 1, 2, 3, 0x7fffff, 0x800000, 0x800001, 0xffffff, 0x1000000, 0x1000001, 0x1ffffff, 0x3f7fffff, 0x3f800000,
                 0x3f800001, 0x3fffffff, 0x40000000, 0x4b000000, 0x4b7fffff, 0x4b800000, 0x33800000, 0x33800001, 0x7effffff,
                 0x7f000000, 0x7f7fffff, 0x7f800000, 0x7fc00000, 0x7fffff80, 0x7fffffc0, 0x7fffffff]
  .flatMap((bits) => [bits, (bits | 0x80000000) >>> 0]);

function drawPairs(count: number): Uint32Array {
  const pairs: number[] = corners.flatMap((a) => corners.flatMap((b) => [a, b]));
  let random = 7;
  const draw = () => {
    random = (Math.imul(random, 1664525) + 1013904223) >>> 0;
    return (random ^ (random >>> 15)) >>> 0;
  };
  while (pairs.length < 2 * count) {
    const a = draw(), b = draw(), kind = pairs.length % 8;
    // Any bits; exponents that are near, so that sums cancel; fractions with few bits, so that halves occur.
    if (kind < 4) pairs.push(a, b);
    else if (kind === 4) pairs.push(a, ((a + (b % 0x3000000) - 0x1800000) ^ (b & 0x80000000)) >>> 0);
    else pairs.push((a & 0xfff80000) >>> 0, (b & 0xfffff800) >>> 0);
  }
  return Uint32Array.from(pairs.slice(0, 2 * count));
}

/** Throws where results differ; returns how many there are. */
export async function checkArithmetic(device: GPUDevice): Promise<number> {
  const count = 1 << 20, pairs = drawPairs(count), floats = new Float32Array(pairs.buffer), expected = new Float32Array(3 * count);
  for (let i = 0; i < count; ++i) {
    expected[3 * i] = floats[2 * i]! * floats[2 * i + 1]!; // exact in 64 bits, or rounded innocuously, then once to 32
    expected[3 * i + 1] = floats[2 * i]! + floats[2 * i + 1]!;
    expected[3 * i + 2] = pairs[2 * i]! | 0;
  }
  const from = device.createBuffer({ size: pairs.byteLength, usage: 128 | 8 });
  const to = device.createBuffer({ size: expected.byteLength, usage: 128 | 4 });
  device.queue.writeBuffer(from, 0, pairs as Uint32Array<ArrayBuffer>);
  const pipeline = device.createComputePipeline({ layout: "auto", compute: { module: device.createShaderModule({ code }) } });
  const group = device.createBindGroup({ layout: pipeline.getBindGroupLayout(0),
                                         entries: [from, to].map((buffer, binding) => ({ binding, resource: { buffer } })) });
  const encoder = device.createCommandEncoder(), pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  pass.setBindGroup(0, group);
  pass.dispatchWorkgroups(count / 64);
  pass.end();
  device.queue.submit([encoder.finish()]);
  const found = await readBuffer(device, to, 0, expected.byteLength), different = countDifferent(found, expected);
  if (different > 0) {
    const bits = new Uint32Array(expected.buffer), at = found.findIndex((word, i) => differs(word, bits[i]!));
    const [a, b] = [pairs[2 * Math.floor(at / 3)]!, pairs[2 * Math.floor(at / 3) + 1]!];
    throw new Error(`${different} results differ, such as number ${at % 3} of ${a.toString(16)} and ${b.toString(16)}: ` +
                    `${found[at]!.toString(16)}, expected ${bits[at]!.toString(16)}`);
  }
  return expected.length;
}

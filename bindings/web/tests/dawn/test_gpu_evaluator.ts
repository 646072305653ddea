// GpuEvaluator in Node, by Dawn, on the adapter that Vulkan names: SwiftShader, or a GPU.
//   FB_DAWN: the module "webgpu"; FB_ARCHIVES: archives, separated by blanks; FB_CROWD: an archive that is posed
//   FB_FACES x FB_POSES times
import assert from "node:assert/strict";
import { basename } from "node:path";
import test, { before } from "node:test";
import { load, type Face } from "facebaker";
import { GpuEvaluator } from "facebaker/webgpu";
import { checkGpuEvaluator, countDifferent, drawPoses, readBuffer } from "../gpu_evaluator_checks.js";
import { checkMadeUpFace } from "../made_up_face_checks.js";
import { checkArithmetic } from "../shader_arithmetic_checks.js";
import { checkVertexBuffer } from "../vertex_buffer_checks.js";

const archives = (process.env["FB_ARCHIVES"] ?? "").split(" ").filter(Boolean);
assert(archives.length > 0, "FB_ARCHIVES names no archives");
const archiveOf = (name: string) => archives.find((archive) => basename(archive, ".fbk") === name)!;
const poses = 67; // not a multiple of those that are summed together

let device: GPUDevice;
const errors: string[] = [];

before(async () => {
  const { create, globals } = await import(process.env["FB_DAWN"]!);
  Object.assign(globalThis, globals);
  const gpu = create([]) as GPU;
  Object.assign(globalThis, { gpu }); // an instance that is collected takes its devices along
  const adapter = (await gpu.requestAdapter())!;
  assert(gpu.wgslLanguageFeatures.has("packed_4x8_integer_dot_product"));
  console.log(`adapter: ${adapter.info.description}`);
  device = await adapter.requestDevice({ requiredLimits: {
    maxBufferSize: adapter.limits.maxBufferSize, maxStorageBufferBindingSize: adapter.limits.maxStorageBufferBindingSize } });
  device.addEventListener("uncapturederror", ({ error }) => errors.push(error.message));
});

async function withFace(archive: string, use: (face: Face) => Promise<void>): Promise<void> {
  const face = await load(archive);
  await use(face);
  face.dispose();
  assert.deepEqual(errors, []);
}

test("the shader's arithmetic is that of the processor", async () => {
  assert((await checkArithmetic(device)) > 3_000_000);
  assert.deepEqual(errors, []);
});

test("row blocks of any size have the processor's bits", async () => {
  assert((await checkMadeUpFace(device)) > 0);
  assert.deepEqual(errors, []);
});

for (const archive of archives)
  test(`${basename(archive)} has the processor's bits`, () => withFace(archive, async (face) => {
    const controls = drawPoses(face, poses);
    for (const integerDot of [true, false])
      for (const vertexOrder of ["source", "baked"] as const) {
        const far = await checkGpuEvaluator(device, face, controls, poses, { integerDot, vertexOrder });
        assert(far < 1e-5, `joints move vertices ${far} of the diagonal elsewhere`);
      }
  }));

test("a vertex shader gets the processor's bits", () => withFace(archiveOf("driven"), async (face) => {
  assert.equal(await checkVertexBuffer(device, face), face.vertexCount);
}));

test("limits of a device are kept within", () => withFace(archiveOf("driven"), async (face) => {
  const controls = drawPoses(face, poses), bytes = 12 * face.vertexCount;
  const { packer } = new GpuEvaluator(device, face) as unknown as { packer: { mostBytes(octets: number): number } };
  const few = { maxComputeWorkgroupsPerDimension: 2, maxStorageBufferBindingSize: packer.mostBytes(1) + 3000 };
  assert(few.maxStorageBufferBindingSize < poses * bytes, "the face is too small for this test");
  assert((await checkGpuEvaluator(device, face, controls, poses, { limits: few })) < 1e-5);
  assert.throws(() => new GpuEvaluator(device, face, { limits: { maxStorageBufferBindingSize: 400 } }),
                /the basis takes \d+ bytes; this device binds at most 400/);
}));

test("what does not fit is refused", () => withFace(archiveOf("driven"), async (face) => {
  const evaluator = new GpuEvaluator(device, face), buffer = evaluator.createBuffer(2), controls = drawPoses(face, 3);
  assert.throws(() => evaluator.evaluate(controls, 3, buffer), /3 poses need a buffer of \d+ bytes; it has \d+/);
  assert.throws(() => evaluator.evaluate(controls, 2, buffer, { offset: 4 }), /need a buffer of/);
  assert.throws(() => evaluator.evaluate(controls, 1, buffer, { offset: 2 }), /offset: 2 is not a multiple of 4/);
  assert.throws(() => evaluator.evaluate(controls.fill(NaN), 1, buffer), /is not a number/);
  assert.throws(() => evaluator.createBuffer(1e9), /a buffer of this device has at most \d+, which is \d+ poses/);
  evaluator.dispose();
}));

test("one digit that is changed shows", () => withFace(archiveOf("character"), async (face) => {
  const block = face.rowBlocks.find(({ columns }) => columns.length > 0)!;
  block.digits[0] = block.digits[0]! === 127 ? 126 : block.digits[0]! + 1;
  await assert.rejects(checkGpuEvaluator(device, face, drawPoses(face, poses), poses), /numbers differ/);
}));

test("a crowd has the processor's bits", { skip: !process.env["FB_CROWD"] }, () => withFace(process.env["FB_CROWD"]!, async (face) => {
  const faces = Number(process.env["FB_FACES"] ?? 1000), times = Number(process.env["FB_POSES"] ?? 64);
  const evaluator = new GpuEvaluator(device, face), { bytes } = evaluator, buffer = evaluator.createBuffer(faces);
  const positions = new Float32Array(3 * face.vertexCount * faces), spent = { processor: 0, adapter: 0 };
  for (let time = 0; time < times; ++time) {
    const controls = drawPoses(face, faces, 1 + time), began = performance.now();
    evaluator.evaluate(controls, faces, buffer, { unskinned: true });
    const submitted = performance.now();
    await device.queue.onSubmittedWorkDone();
    spent.processor += submitted - began;
    spent.adapter += performance.now() - submitted;
    const found = await readBuffer(device, buffer, 0, evaluator.bytesOf(faces));
    face.evaluateBatch(controls, faces, { positions, unskinned: true });
    assert.equal(countDifferent(found, positions), 0, `pose ${time}`);
  }
  const each = (milliseconds: number) => `${(milliseconds / times).toFixed(0)} ms`;
  console.log(`${faces} faces of ${face.vertexCount} vertices, ${times} poses each: the same bits; ${each(spent.processor)} of the ` +
              `processor and ${each(spent.adapter)} of the adapter for all faces in a pose; bytes ${JSON.stringify(bytes)}`);
  evaluator.dispose();
  buffer.destroy();
}));

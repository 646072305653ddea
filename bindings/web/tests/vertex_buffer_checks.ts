// Positions of GpuEvaluator as a vertex buffer: a point a vertex, which writes what it got into a texel of its own.
import type { Face } from "facebaker";
import { GpuEvaluator } from "facebaker/webgpu";
import { countDifferent, drawPoses } from "./gpu_evaluator_checks.js";

const width = 64; // a row of four floats a texel is 1,024 bytes: copies are of rows of whole 256
const shader = (height: number) => `
struct Corner { @builtin(position) at: vec4<f32>, @location(0) @interpolate(flat, either) got: vec4<f32> }
@vertex fn place(@location(0) position: vec3<f32>, @builtin(vertex_index) vertex: u32) -> Corner {
  let texel = vec2(f32(vertex % ${width}u), f32(vertex / ${width}u)) + 0.5;
  return Corner(vec4(texel / vec2(${width}.0, ${height}.0) * vec2(2.0, -2.0) + vec2(-1.0, 1.0), 0.0, 1.0), vec4(position, 1.0));
}
@fragment fn write(corner: Corner) -> @location(0) vec4<f32> { return corner.got; }
`;

/** Draws the last of three poses. Throws where a vertex shader gets other bits than Face.evaluate gives. */
export async function checkVertexBuffer(device: GPUDevice, face: Face): Promise<number> {
  const poses = 3, { vertexCount } = face, height = Math.ceil(vertexCount / width);
  const controls = drawPoses(face, poses), evaluator = new GpuEvaluator(device, face), positions = evaluator.createBuffer(poses);
  const target = device.createTexture({ size: [width, height], format: "rgba32float", usage: 16 | 1 }); // drawn, copied
  const read = device.createBuffer({ size: 16 * width * height, usage: 9 });
  const module = device.createShaderModule({ code: shader(height) });
  const pipeline = device.createRenderPipeline({
    layout: "auto", primitive: { topology: "point-list" },
    vertex: { module, buffers: [{ arrayStride: 12, attributes: [{ format: "float32x3", offset: 0, shaderLocation: 0 }] }] },
    fragment: { module, targets: [{ format: "rgba32float" }] },
  });
  evaluator.evaluate(controls, poses, positions, { unskinned: true });
  const encoder = device.createCommandEncoder();
  const pass = encoder.beginRenderPass({ colorAttachments: [{ view: target.createView(), loadOp: "clear", storeOp: "store" }] });
  pass.setPipeline(pipeline);
  pass.setVertexBuffer(0, positions, evaluator.bytesOf(poses - 1), evaluator.bytesOf(1));
  pass.draw(vertexCount);
  pass.end();
  encoder.copyTextureToBuffer({ texture: target }, { buffer: read, bytesPerRow: 16 * width }, [width, height]);
  device.queue.submit([encoder.finish()]);
  await read.mapAsync(1);
  const texels = new Uint32Array(read.getMappedRange().slice(0)), found = new Uint32Array(3 * vertexCount);
  for (let i = 0; i < found.length; ++i) found[i] = texels[4 * Math.floor(i / 3) + (i % 3)]!;
  const pose = controls.subarray((poses - 1) * face.controlCount);
  const expected = face.evaluateInto(pose, { positions: new Float32Array(3 * vertexCount), unskinned: true }).positions;
  const different = countDifferent(found, expected);
  if (different > 0) throw new Error(`a vertex shader gets ${different} of ${found.length} numbers otherwise`);
  evaluator.dispose();
  for (const one of [positions, target, read]) one.destroy();
  return vertexCount;
}

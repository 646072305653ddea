// GpuEvaluator in a browser.
import { load } from "facebaker";
import { checkGpuEvaluator } from "../gpu_evaluator_checks.js";
import { readExpectedPoses } from "../expected_poses.js";
import { checkMadeUpFace } from "../made_up_face_checks.js";
import { checkArithmetic } from "../shader_arithmetic_checks.js";
import { checkVertexBuffer } from "../vertex_buffer_checks.js";

/** Compares poses of a dump; returns what was compared, and how far skinned positions are apart, over the diagonal. */
export async function evaluateOnGpu(archive: string, dump: string, poses: number): Promise<{ said: string; skinned: number }> {
  const { controls } = readExpectedPoses(await (await fetch(dump)).arrayBuffer()), face = await load(archive);
  const adapter = (await navigator.gpu.requestAdapter())!, device = await adapter.requestDevice(), errors: string[] = [];
  device.addEventListener("uncapturederror", ({ error }) => errors.push(error.message));
  const skinned = await checkGpuEvaluator(device, face, controls, poses); // as pages get it
  await checkGpuEvaluator(device, face, controls, 9, { integerDot: false, vertexOrder: "baked" });
  await checkMadeUpFace(device);
  const drawn = await checkVertexBuffer(device, face), results = await checkArithmetic(device);
  device.destroy();
  face.dispose();
  if (errors.length > 0) throw new Error(errors.join("; "));
  return { said: `${poses} poses, ${drawn} vertices drawn, ${results} results of the shader's arithmetic`, skinned };
}

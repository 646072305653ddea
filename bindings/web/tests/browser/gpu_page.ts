// Poses on the GPU, compared with the processor's.
import { load } from "facebaker";
import { FaceBakerMesh } from "facebaker/three";
import { FaceBakerGpuMesh } from "facebaker/three-gpu";
import { AmbientLight, DirectionalLight, PerspectiveCamera, Scene, WebGLRenderer, type Group } from "three";
import { readExpectedPoses } from "../expected_poses.js";

export interface GpuDifference {
  /** Largest distance of a vertex from the processor's, over the diagonal. */
  position: number;
  /** Largest angle between normals, in degrees. */
  normal: number;
  /** Largest difference of a colour channel of the pictures of both, 0 to 255, and the share of pixels that differ by
   * more than 8. */
  picture: number;
  differing: number;
  /** Pixels that are not background. */
  covered: number;
  basisBytes: number;
  poses: number;
}

function draw(renderer: WebGLRenderer, group: Group, radius: number, centre: number[]): Uint8Array {
  const scene = new Scene(), light = new DirectionalLight(0xffffff, 2), size = renderer.domElement.width;
  const camera = new PerspectiveCamera(30, 1, radius / 10, 10 * radius);
  camera.position.set(centre[0]! + radius, centre[1]! + radius / 2, centre[2]! + 2 * radius);
  camera.lookAt(centre[0]!, centre[1]!, centre[2]!);
  light.position.set(1, 2, 3);
  scene.add(group, light, new AmbientLight(0xffffff, 0.3));
  renderer.setRenderTarget(null);
  renderer.render(scene, camera);
  const gl = renderer.getContext(), pixels = new Uint8Array(4 * size * size);
  gl.readPixels(0, 0, size, size, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  scene.remove(group);
  return pixels;
}

export async function drawOnGpu(archive: string, dump: string): Promise<GpuDifference> {
  const expected = readExpectedPoses(await (await fetch(dump)).arrayBuffer());
  const face = await load(archive), n = face.controlCount, size = 3 * face.vertexCount;
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 400;
  document.body.append(canvas);
  const renderer = new WebGLRenderer({ canvas, antialias: false, preserveDrawingBuffer: true });
  renderer.setSize(400, 400, false);
  const gpu = new FaceBakerGpuMesh(face), cpu = new FaceBakerMesh(face);
  const result: GpuDifference = { position: 0, normal: 0, picture: 0, differing: 0, covered: 0,
                                  basisBytes: gpu.basisBytes, poses: 64 };
  for (let p = 0; p < result.poses; ++p) {
    gpu.update(expected.controls.subarray(p * n, p * n + n), renderer);
    const { positions, normals } = gpu.read(renderer);
    for (let v = 0; v < face.vertexCount; ++v) {
      const at = (values: Float32Array, first: number) => [0, 1, 2].map((axis) => values[first + 3 * v + axis]!);
      const a = at(positions, 0), b = at(expected.positions, p * size);
      result.position = Math.max(result.position, Math.hypot(...a.map((x, i) => x - b[i]!)) / face.diagonal);
      const x = at(normals, 0), y = at(expected.normals, p * size);
      const [sx, sy, sz] = [x[1]! * y[2]! - x[2]! * y[1]!, x[2]! * y[0]! - x[0]! * y[2]!, x[0]! * y[1]! - x[1]! * y[0]!];
      const angle = Math.atan2(Math.hypot(sx, sy, sz), x[0]! * y[0]! + x[1]! * y[1]! + x[2]! * y[2]!);
      result.normal = Math.max(result.normal, (angle * 180) / Math.PI);
    }
  }
  const controls = expected.controls.subarray(n, 2 * n), bounds = face.evaluateInto(controls, { bounds: new Float32Array(6) }).bounds;
  const centre = [0, 1, 2].map((axis) => (bounds[axis]! + bounds[axis + 3]!) / 2);
  gpu.update(controls, renderer);
  cpu.update(controls);
  const first = draw(renderer, cpu, face.diagonal, centre), last = draw(renderer, gpu, face.diagonal, centre);
  for (let i = 0; i < first.length; i += 4) {
    const by = Math.max(...[0, 1, 2].map((c) => Math.abs(first[i + c]! - last[i + c]!)));
    result.picture = Math.max(result.picture, by);
    if (by > 8) result.differing += 4 / first.length;
    if (first[i]! + first[i + 1]! + first[i + 2]! > 0) ++result.covered;
  }
  gpu.dispose();
  cpu.dispose();
  renderer.dispose();
  face.dispose();
  return result;
}

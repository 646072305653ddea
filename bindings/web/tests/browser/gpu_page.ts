// Poses on the GPU, compared with the processor's: by WebGLRenderer, and by WebGPURenderer with WebGPU and with WebGL 2.
import { load, type Face } from "facebaker";
import { FaceBakerMesh, type FaceBakerMeshOptions } from "facebaker/three";
import { FaceBakerGpuMesh } from "facebaker/three-gpu";
import { FaceBakerNodeMesh } from "facebaker/three-webgpu";
import { AmbientLight, Color, DataTexture, DirectionalLight, PerspectiveCamera, RenderTarget, Scene, SRGBColorSpace, WebGLRenderer,
         WebGLRenderTarget, type Group } from "three";
import { WebGPURenderer } from "three/webgpu";
import { readExpectedPoses, type ExpectedPoses } from "../expected_poses.js";

export interface GpuDifference {
  /** "webgl", or what WebGPURenderer draws with. */
  backend: string;
  /** Largest distance of a vertex from the processor's, over the diagonal. */
  position: number;
  /** Largest angle between normals, in degrees. */
  normal: number;
  /** Largest difference of a colour channel of the pictures of both, 0 to 255, and the share of pixels that differ by
   * more than 8. */
  picture: number;
  differing: number;
  /** Pixels that are not background, and the mean brightness of these, 0 to 255. */
  covered: number;
  brightness: number;
  /** Bones of the skin that were turned for the picture. */
  bones: number;
  /** Driven joints, and how far they move a vertex at most, over the diagonal. */
  joints: number;
  moved: number;
  basisBytes: number;
  poses: number;
  /** What classes say of this renderer: that they can draw with it. */
  supported: { webgl: boolean; webgpu: boolean };
}

interface Posed {
  positions: Float32Array;
  normals: Float32Array;
}

// A renderer with the mesh whose vertices it moves.
interface Drawing {
  backend: string;
  mesh: FaceBakerGpuMesh | FaceBakerNodeMesh;
  renderer: WebGLRenderer | WebGPURenderer;
  update(controls: Float32Array): void;
  read(): Promise<Posed>;
  draw(scene: Scene, camera: PerspectiveCamera): Promise<Uint8Array>;
}

const size = 400;

// In place of the pictures of a face, which arrive at some time or other: two by two texels.
const options: FaceBakerMeshOptions = { loadTexture: () => {
  const texture = new DataTexture(Uint8Array.of(255, 200, 180, 255, 90, 128, 255, 255, 128, 128, 255, 255, 200, 100, 50, 255), 2, 2);
  texture.needsUpdate = true;
  return texture;
} };

function drawByWebGL(face: Face, canvas: HTMLCanvasElement): Drawing {
  const renderer = new WebGLRenderer({ canvas, antialias: false }), mesh = new FaceBakerGpuMesh(face, options);
  const target = new WebGLRenderTarget(size, size, { colorSpace: SRGBColorSpace });
  return {
    backend: "webgl", mesh, renderer,
    update: (controls) => mesh.update(controls, renderer),
    read: async () => mesh.read(renderer),
    draw: async (scene, camera) => {
      renderer.setRenderTarget(target);
      renderer.render(scene, camera);
      const pixels = new Uint8Array(4 * size * size);
      renderer.readRenderTargetPixels(target, 0, 0, size, size, pixels);
      renderer.setRenderTarget(null);
      renderer.render(scene, camera); // for the screenshot
      return pixels;
    },
  };
}

async function drawByWebGPU(face: Face, canvas: HTMLCanvasElement, forceWebGL: boolean): Promise<Drawing> {
  const renderer = new WebGPURenderer({ canvas, antialias: false, forceWebGL });
  await renderer.init();
  const mesh = new FaceBakerNodeMesh(face, options), target = new RenderTarget(size, size, { colorSpace: SRGBColorSpace });
  return {
    backend: "isWebGPUBackend" in renderer.backend ? "webgpu" : "webgpu-webgl2", mesh, renderer,
    update: (controls) => mesh.update(controls, renderer),
    read: () => mesh.read(renderer),
    draw: async (scene, camera) => {
      renderer.setRenderTarget(target);
      renderer.render(scene, camera);
      const pixels = await renderer.readRenderTargetPixelsAsync(target, 0, 0, size, size) as Uint8Array;
      renderer.setRenderTarget(null);
      renderer.render(scene, camera);
      return pixels.slice();
    },
  };
}

function comparePose(result: GpuDifference, face: Face, found: Posed, expected: ExpectedPoses, first: number): void {
  for (let v = 0; v < face.vertexCount; ++v) {
    const at = (values: Float32Array, from: number) => [0, 1, 2].map((axis) => values[from + 3 * v + axis]!);
    const a = at(found.positions, 0), b = at(expected.positions, first);
    result.position = Math.max(result.position, Math.hypot(...a.map((x, i) => x - b[i]!)) / face.diagonal);
    if (expected.unskinned) {
      const before = at(expected.unskinned, first);
      result.moved = Math.max(result.moved, Math.hypot(...a.map((x, i) => x - before[i]!)) / face.diagonal);
    }
    const x = at(found.normals, 0), y = at(expected.normals, first);
    const [sx, sy, sz] = [x[1]! * y[2]! - x[2]! * y[1]!, x[2]! * y[0]! - x[0]! * y[2]!, x[0]! * y[1]! - x[1]! * y[0]!];
    const angle = Math.atan2(Math.hypot(sx, sy, sz), x[0]! * y[0]! + x[1]! * y[1]! + x[2]! * y[2]!);
    result.normal = Math.max(result.normal, (angle * 180) / Math.PI);
  }
}

async function picture(drawing: Drawing, group: Group, radius: number, centre: readonly number[]): Promise<Uint8Array> {
  const scene = new Scene(), light = new DirectionalLight(0xffffff, 2);
  const camera = new PerspectiveCamera(30, 1, radius / 10, 10 * radius);
  camera.position.set(centre[0]! + radius, centre[1]! + radius / 2, centre[2]! + 2 * radius);
  camera.lookAt(centre[0]!, centre[1]!, centre[2]!);
  light.position.set(1, 2, 3);
  scene.background = new Color(0x000000);
  scene.add(group, light, new AmbientLight(0xffffff, 0.3));
  return drawing.draw(scene, camera);
}

async function comparePictures(result: GpuDifference, drawing: Drawing, face: Face, controls: Float32Array): Promise<void> {
  const { bounds } = face.evaluateInto(controls, { bounds: new Float32Array(6) });
  const centre = [0, 1, 2].map((axis) => (bounds[axis]! + bounds[axis + 3]!) / 2), cpu = new FaceBakerMesh(face, options);
  for (const { bones } of [cpu, drawing.mesh]) bones.forEach((bone, index) => bone.rotateX(0.3 - 0.1 * (index % 3)));
  result.bones = cpu.bones.length;
  drawing.update(controls);
  cpu.update(controls);
  const first = await picture(drawing, cpu, face.diagonal, centre);
  const last = await picture(drawing, drawing.mesh, face.diagonal, centre);
  for (let i = 0; i < first.length; i += 4) {
    const by = Math.max(...[0, 1, 2].map((c) => Math.abs(first[i + c]! - last[i + c]!)));
    result.picture = Math.max(result.picture, by);
    if (by > 8) result.differing += 4 / first.length;
    const sum = last[i]! + last[i + 1]! + last[i + 2]!;
    if (sum > 0) ++result.covered;
    result.brightness += sum / 3;
  }
  result.brightness /= result.covered;
  cpu.dispose();
}

/** `kind`: "webgl", "webgpu" or "webgpu-webgl2". */
export async function drawOnGpu(archive: string, dump: string, kind: string, poses: number): Promise<GpuDifference> {
  const expected = readExpectedPoses(await (await fetch(dump)).arrayBuffer());
  const face = await load(archive), n = face.controlCount, canvas = document.createElement("canvas");
  canvas.width = canvas.height = size;
  document.body.replaceChildren(canvas);
  const drawing = kind === "webgl" ? drawByWebGL(face, canvas) : await drawByWebGPU(face, canvas, kind !== "webgpu");
  drawing.renderer.setSize(size, size, false);
  const { mesh, renderer } = drawing;
  const result: GpuDifference = {
    backend: drawing.backend, position: 0, normal: 0, picture: 0, differing: 0, covered: 0, brightness: 0, bones: 0,
    joints: face.drivenJoints.length, moved: 0, basisBytes: mesh.basisBytes, poses,
    supported: { webgl: FaceBakerGpuMesh.isSupported(renderer), webgpu: FaceBakerNodeMesh.isSupported(renderer) },
  };
  for (let p = 0; p < poses; ++p) {
    drawing.update(expected.controls.subarray(p * n, p * n + n));
    comparePose(result, face, await drawing.read(), expected, 3 * p * face.vertexCount);
  }
  await comparePictures(result, drawing, face, expected.controls.subarray(n, 2 * n));
  mesh.dispose();
  renderer.dispose();
  face.dispose();
  return result;
}

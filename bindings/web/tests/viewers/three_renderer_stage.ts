// A stage of three.js, whichever of its renderers draws.
import type { Camera, Scene } from "three";
import { addFace } from "./examples/three_js.js";
import { addGlb, makeCamera, makeScene, shownMesh } from "./three_stages.js";
import { pixelsOf, size, type Stage, type View } from "./viewer_stage.js";

/** What the renderers for WebGL and WebGPU have in common. */
interface AnyRenderer {
  readonly info: { readonly memory: { readonly geometries: number; readonly textures: number } };
  setSize(width: number, height: number, style: boolean): void;
  render(scene: Scene, camera: Camera): unknown;
}

export function rendererStage(renderer: AnyRenderer, backend: string, canvas: HTMLCanvasElement, view: View): Stage {
  const scene = makeScene(), camera = makeCamera(view);
  renderer.setSize(size, size, false);
  return {
    backend,
    showFace: async (face) => {
      const { mesh, pose, remove } = addFace(face, scene);
      return shownMesh(mesh, pose, remove);
    },
    showGlb: (bytes) => addGlb(scene, bytes),
    draw: async () => {
      renderer.render(scene, camera);
      return pixelsOf(canvas);
    },
    counts: () => ({ geometries: renderer.info.memory.geometries, textures: renderer.info.memory.textures, objects: scene.children.length }),
  };
}

import { addFace } from "./examples/a_frame.js";
import type { PerspectiveCamera, Scene, WebGLRenderer } from "three";
import { offer } from "./compare_viewer.js";
import { addGlb, makeCamera, makeScene, shownMesh } from "./three_stages.js";
import { pixelsOf, size, until } from "./viewer_stage.js";

interface SceneElement extends HTMLElement {
  hasLoaded: boolean;
  object3D: Scene;
  camera: PerspectiveCamera;
  renderer: WebGLRenderer;
  time: number;
  tick(time: number, delta: number): void;
}

offer(async (canvas, view) => {
  canvas.remove(); // it makes its own
  document.body.insertAdjacentHTML("beforeend",
    `<a-scene embedded style="width: ${size}px; height: ${size}px" vr-mode-ui="enabled: false" loading-screen="enabled: false" ` +
    `renderer="antialias: false" light="defaultLightsEnabled: false"><a-entity camera></a-entity></a-scene>`);
  const element = document.querySelector("a-scene") as unknown as SceneElement;
  await until(() => element.hasLoaded && !!element.renderer && !!element.camera, "A-Frame's scene");
  const { renderer, object3D: scene } = element, camera = makeCamera(view);
  scene.add(...makeScene().children);
  renderer.setAnimationLoop(null);
  renderer.setPixelRatio(1);
  renderer.setSize(size, size, false);
  return {
    backend: "webgl",
    showFace: async (_face, archive) => {
      const { entity, loaded: { model, controls } } = await addFace(element, archive);
      return shownMesh(model, (pose) => controls.set(pose), () => entity.remove());
    },
    showGlb: (bytes) => addGlb(scene, bytes),
    draw: async () => {
      await new Promise((resolve) => setTimeout(resolve, 50)); // A-Frame's turn
      element.tick(element.time += 16, 16);
      renderer.render(scene, camera);
      return pixelsOf(renderer.domElement);
    },
    counts: () => ({ geometries: renderer.info.memory.geometries, textures: renderer.info.memory.textures, entities: element.children.length,
                     objects: scene.children.length }),
  };
});

import { WebGPURenderer } from "three/webgpu";
import { addFace } from "./examples/three_js.js";
import { offer } from "./compare_viewer.js";
import { addGlb, makeCamera, makeScene, shownMesh } from "./three_stages.js";
import { pixelsOf, size } from "./viewer_stage.js";

offer(async (canvas, view) => {
  const renderer = new WebGPURenderer({ canvas, antialias: false }), scene = makeScene(), camera = makeCamera(view);
  await renderer.init();
  renderer.setSize(size, size, false);
  return {
    backend: "isWebGPUBackend" in renderer.backend ? "webgpu" : "webgl",
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
});

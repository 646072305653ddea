import { WebGLRenderer } from "three";
import { addFace } from "./examples/three_js.js";
import { offer } from "./compare_viewer.js";
import { addGlb, makeCamera, makeScene, shownMesh } from "./three_stages.js";
import { pixelsOf, size } from "./viewer_stage.js";

offer(async (canvas, view) => {
  const renderer = new WebGLRenderer({ canvas, antialias: false }), scene = makeScene(), camera = makeCamera(view);
  renderer.setSize(size, size, false);
  return {
    backend: "webgl",
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

import { createRoot, extend } from "@react-three/fiber";
import * as THREE from "three";
import type { FaceBakerMesh } from "facebaker/three";
import { Face } from "./examples/react_three_fiber.jsx";
import { offer } from "./compare_viewer.js";
import { freeObject, loadGlb, makeCamera, shownMesh } from "./three_stages.js";
import { light, pixelsOf, size, until } from "./viewer_stage.js";

extend(THREE as never);

offer(async (canvas, view) => {
  const root = createRoot(canvas), camera = makeCamera(view);
  await root.configure({ camera: camera as never, frameloop: "never", dpr: 1, gl: { antialias: false },
                         size: { width: size, height: size, top: 0, left: 0 } });
  const show = (child: unknown) => root.render(
    <>
      <directionalLight intensity={light.intensity} position={[...light.from]} />
      <ambientLight intensity={light.ambient} />
      {child as never}
    </>);
  const store = show(null);
  await until(() => store.getState().scene.children.length > 1, "the scene");
  const { gl, scene } = store.getState(), without = scene.children.length;
  const mounted = (count: number) => until(() => scene.children.length === without + count, "what React shows");
  let time = 0;
  return {
    backend: "webgl",
    showFace: async (face) => {
      const controls = face.createPose();
      show(<Face face={face} controls={controls} />);
      await mounted(1);
      const mesh = scene.children.at(-1) as unknown as FaceBakerMesh;
      return shownMesh(mesh, (pose) => controls.set(pose), () => show(null));
    },
    showGlb: async (bytes) => {
      const object = await loadGlb(bytes);
      show(<primitive object={object} />);
      await mounted(1);
      return () => {
        show(null);
        freeObject(object);
      };
    },
    draw: async () => {
      await new Promise((resolve) => setTimeout(resolve, 50)); // React's turn
      store.getState().advance(++time);
      return pixelsOf(canvas);
    },
    counts: () => ({ geometries: gl.info.memory.geometries, textures: gl.info.memory.textures, objects: scene.children.length }),
  };
});

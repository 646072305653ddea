import { Axis, Color4, DirectionalLight, Engine, FreeCamera, HemisphericLight, LoadAssetContainerAsync, Quaternion, Scene, Vector3,
         type Bone } from "@babylonjs/core";
import "@babylonjs/loaders/glTF/index.js";
import { addFace } from "./examples/babylon_js.js";
import type { FaceBakerNode } from "facebaker/babylon";
import { offer } from "./compare_viewer.js";
import { fieldOfView, light, pixelsOf, type MakeStage, type View } from "./viewer_stage.js";

/** What is at x in a right-handed scene is at -x in a left-handed one. */
const place = (scene: Scene, [x, y, z]: readonly [number, number, number]) => new Vector3(scene.useRightHandedSystem ? x : -x, y, z);

function addLights(scene: Scene): void {
  const sun = new DirectionalLight("sun", place(scene, light.from).scale(-1), scene);
  sun.intensity = light.intensity;
  const sky = new HemisphericLight("sky", new Vector3(0, 1, 0), scene);
  sky.intensity = light.ambient;
  sky.groundColor.set(1, 1, 1);
}

function look(scene: Scene, view: View): void {
  const camera = new FreeCamera("camera", place(scene, view.eye), scene);
  camera.setTarget(place(scene, view.centre));
  camera.fov = (fieldOfView * Math.PI) / 180;
  camera.minZ = view.near;
  camera.maxZ = view.far;
}

const makeBabylonStage = (rightHanded: boolean): MakeStage => async (canvas, view) => {
  const engine = new Engine(canvas, false, { preserveDrawingBuffer: true }), scene = new Scene(engine);
  scene.useRightHandedSystem = rightHanded;
  scene.clearColor = new Color4(0, 0, 0, 1);
  addLights(scene);
  look(scene, view);
  return {
    backend: "webgl",
    showFace: async (face) => {
      const { node, pose, remove } = addFace(face, scene);
      const turn = (bone: Bone, angle: number) => {
        bone.returnToRest();
        bone.rotationQuaternion = bone.rotationQuaternion.multiply(Quaternion.RotationAxis(Axis.X, angle));
      };
      return {
        pose(controls, turns) {
          if (turns) (node as FaceBakerNode).bones.forEach((bone, index) => turn(bone, turns[index]!));
          pose(controls);
        },
        ready: () => node.ready,
        remove,
      };
    },
    showGlb: async (bytes) => {
      const container = await LoadAssetContainerAsync(new Uint8Array(bytes), scene, { pluginExtension: ".glb" });
      container.addAllToScene();
      return () => container.dispose();
    },
    draw: async () => {
      await scene.whenReadyAsync();
      scene.render();
      return pixelsOf(canvas);
    },
    counts: () => ({ meshes: scene.meshes.length, nodes: scene.transformNodes.length, materials: scene.materials.length + scene.multiMaterials.length,
                     textures: scene.textures.length, skeletons: scene.skeletons.length, geometries: scene.geometries.length }),
  };
};

offer(makeBabylonStage(new URLSearchParams(location.search).get("handed") !== "left"));

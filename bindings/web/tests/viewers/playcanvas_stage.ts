import { Application, Asset, Color, Entity, FILLMODE_NONE, RESOLUTION_FIXED, type ContainerResource } from "playcanvas";
import { addFace } from "./examples/playcanvas.js";
import type { FaceBakerEntity } from "facebaker/playcanvas";
import { offer } from "./compare_viewer.js";
import { fieldOfView, light, pixelsOf, size, type View } from "./viewer_stage.js";

function addLights(app: Application): void {
  const sun = new Entity("sun", app);
  sun.addComponent("light", { type: "directional", intensity: light.intensity / Math.PI });
  sun.setPosition(...light.from);
  sun.lookAt(0, 0, 0);
  sun.rotateLocal(90, 0, 0); // lights shine down their y axis
  app.root.addChild(sun);
  const ambient = light.ambient / Math.PI;
  app.scene.ambientLight = new Color(ambient, ambient, ambient);
}

function look(app: Application, view: View): void {
  const camera = new Entity("camera", app);
  camera.addComponent("camera", { clearColor: new Color(0, 0, 0, 1), fov: fieldOfView, nearClip: view.near, farClip: view.far });
  camera.setPosition(...view.eye);
  camera.lookAt(...view.centre);
  app.root.addChild(camera);
}

const loadContainer = (app: Application, bytes: Uint8Array): Promise<Asset> => new Promise((resolve, reject) => {
  const asset = new Asset("plain.glb", "container", { url: "plain.glb", filename: "plain.glb", contents: bytes.slice().buffer } as never);
  asset.once("load", () => resolve(asset));
  asset.once("error", (message: string) => reject(new Error(message)));
  app.assets.add(asset);
  app.assets.load(asset);
});

offer(async (canvas, view) => {
  const app = new Application(canvas, { graphicsDeviceOptions: { antialias: false, preserveDrawingBuffer: true } });
  app.autoRender = false;
  app.setCanvasFillMode(FILLMODE_NONE, size, size);
  app.setCanvasResolution(RESOLUTION_FIXED, size, size);
  app.start();
  addLights(app);
  look(app, view);
  return {
    backend: app.graphicsDevice.isWebGPU ? "webgpu" : "webgl",
    showFace: async (face) => {
      const { entity, pose, remove } = addFace(face, app), { bones } = entity as FaceBakerEntity;
      const rest = bones.map((bone) => bone.getLocalRotation().clone());
      return {
        pose(controls, turns) {
          if (turns) bones.forEach((bone, index) => {
            bone.setLocalRotation(rest[index]!);
            bone.rotateLocal((turns[index]! * 180) / Math.PI, 0, 0);
          });
          pose(controls);
        },
        ready: () => entity.ready,
        remove,
      };
    },
    showGlb: async (bytes) => {
      const asset = await loadContainer(app, bytes), entity = (asset.resource as ContainerResource).instantiateRenderEntity();
      app.root.addChild(entity);
      return () => {
        entity.destroy();
        asset.unload();
        app.assets.remove(asset);
      };
    },
    draw: async () => {
      app.render();
      return pixelsOf(canvas);
    },
    counts: () => ({ entities: app.root.find(() => true).length, buffers: app.graphicsDevice.buffers.size,
                     textures: app.graphicsDevice.textures.size }),
  };
});

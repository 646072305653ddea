// Scenes of three.js, as the stages of all viewers that are made of it have them.
import { AmbientLight, DirectionalLight, PerspectiveCamera, Scene, type Bone, type Material, type Mesh, type Object3D, type Quaternion } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import type { FaceBakerMesh } from "facebaker/three";
import { fieldOfView, light, until, type ShownFace, type View } from "./viewer_stage.js";

export function makeCamera(view: View): PerspectiveCamera {
  const camera = new PerspectiveCamera(fieldOfView, 1, view.near, view.far);
  camera.position.set(...view.eye);
  camera.lookAt(...view.centre);
  return camera;
}

export function makeScene(): Scene {
  const scene = new Scene(), sun = new DirectionalLight(0xffffff, light.intensity);
  sun.position.set(...light.from);
  scene.add(sun, new AmbientLight(0xffffff, light.ambient));
  return scene;
}

export const loadGlb = async (bytes: Uint8Array): Promise<Object3D> =>
  (await new GLTFLoader().parseAsync(bytes.slice().buffer, "")).scene;

const materialsOf = (object: Object3D): Material[] => [(object as Mesh).material ?? []].flat();

/** Frees what a loaded file has. */
export function freeObject(root: Object3D): void {
  root.removeFromParent();
  root.traverse((object) => {
    (object as Partial<Mesh>).geometry?.dispose();
    for (const material of materialsOf(object)) {
      for (const value of Object.values(material))
        if ((value as { isTexture?: boolean } | null)?.isTexture) (value as { dispose(): void }).dispose();
      material.dispose();
    }
  });
}

/** Puts a .glb into a scene. */
export async function addGlb(scene: Object3D, bytes: Uint8Array): Promise<() => void> {
  const root = await loadGlb(bytes);
  scene.add(root);
  return () => freeObject(root);
}

function turnBones(bones: readonly Bone[], turns: readonly number[] | null, rest: readonly Quaternion[]): void {
  bones.forEach((bone, index) => {
    bone.quaternion.copy(rest[index]!);
    bone.rotateX(turns?.[index] ?? 0);
  });
}

/** A FaceBakerMesh as the test wants it. */
export function shownMesh(mesh: FaceBakerMesh, pose: (controls: Float32Array) => void, remove: () => void): ShownFace {
  const rest = mesh.bones.map(({ quaternion }) => quaternion.clone());
  const maps = () => mesh.materials.flatMap((material) =>
    [material.map, material.normalMap, material.aoMap, material.roughnessMap, material.emissiveMap]).filter((map) => map !== null);
  return {
    pose(controls, turns) {
      turnBones(mesh.bones, turns, rest);
      pose(controls);
    },
    ready: () => until(() => maps().every(({ image }) => image), "a texture"),
    remove,
  };
}

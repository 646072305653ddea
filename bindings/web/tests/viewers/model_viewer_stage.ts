import { morphTargets } from "./examples/model_viewer.js";
import { offer } from "./compare_viewer.js";
import { fieldOfView, pixelsOf, size, until, type View } from "./viewer_stage.js";

interface ModelViewer extends HTMLElement {
  src: string | null;
  currentTime: number;
  jumpCameraToGoal(): void;
  getCameraTarget(): { x: number; y: number; z: number };
  getCameraOrbit(): { radius: number };
  getFieldOfView(): number;
  toBlob(options: object): Promise<Blob>;
  updateComplete: Promise<void>;
}

// Where the camera is, as model-viewer has it: angles about the target, and a distance.
function lookFrom({ centre, eye }: View): Record<string, string> {
  const [x, y, z] = eye.map((value, axis) => value - centre[axis]!) as [number, number, number], radius = Math.hypot(x, y, z);
  return {
    "camera-target": centre.map((value) => `${value.toFixed(6)}m`).join(" "),
    "camera-orbit": `${Math.atan2(x, z).toFixed(6)}rad ${Math.acos(y / radius).toFixed(6)}rad ${radius.toFixed(6)}m`,
    "max-camera-orbit": `auto auto ${(2 * radius).toFixed(6)}m`, "field-of-view": `${fieldOfView}deg`,
  };
}

offer(async (canvas, view) => {
  canvas.remove(); // it makes its own
  // On a slow machine it draws fewer pixels.
  (customElements.get("model-viewer") as unknown as { minimumRenderScale: number }).minimumRenderScale = 1;
  const viewer = document.createElement("model-viewer") as unknown as ModelViewer;
  for (const [name, value] of Object.entries({ ...lookFrom(view), loading: "eager", "interaction-prompt": "none" })) viewer.setAttribute(name, value);
  viewer.style.cssText = `width: ${size}px; height: ${size}px; background: black`;
  document.body.append(viewer);
  const wanted = [...view.centre, Math.hypot(...view.eye.map((value, axis) => value - view.centre[axis]!)), fieldOfView];
  const settled = () => {
    viewer.jumpCameraToGoal();
    const { x, y, z } = viewer.getCameraTarget(), { radius } = viewer.getCameraOrbit();
    return [x, y, z, radius, viewer.getFieldOfView()].every((value, i) => Math.abs(value - wanted[i]!) < 1e-4 * wanted[3]!);
  };
  const show = async (address: string) => {
    await new Promise<void>((resolve, reject) => {
      viewer.addEventListener("load", () => resolve(), { once: true });
      viewer.addEventListener("error", () => reject(new Error(`${address} is not shown`)), { once: true });
      viewer.src = address;
    });
    await until(settled, "the camera"); // it frames each file anew, later than it says that it is loaded
  };
  const hide = () => { viewer.src = null; };
  return {
    backend: "webgl",
    showFace: async (face, archive) => {
      await show(archive.replace(/\.fbk$/, ".glb"));
      const set = morphTargets(viewer);
      return {
        pose: (controls) => set(Object.fromEntries(face.controls.flatMap(({ name, minimum, neutral, maximum }, index) => {
          const value = Math.min(Math.max(controls[index]!, minimum), maximum) - neutral;
          return [[name, Math.max(value / (maximum - neutral), 0)], [`${name}-`, Math.max(-value / (neutral - minimum), 0)]];
        }))),
        ready: () => viewer.updateComplete,
        remove: hide,
      };
    },
    showGlb: async (bytes) => {
      const address = URL.createObjectURL(new Blob([new Uint8Array(bytes)], { type: "model/gltf-binary" }));
      await show(address);
      URL.revokeObjectURL(address);
      return hide;
    },
    draw: async () => {
      viewer.currentTime = viewer.currentTime; // draws in frames of its own
      for (let frame = 0; frame < 4; ++frame) await new Promise(requestAnimationFrame);
      return pixelsOf(await createImageBitmap(await viewer.toBlob({ mimeType: "image/png" })));
    },
    counts: () => ({}),
  };
});

import { WebGPURenderer } from "three/webgpu";
import { offer } from "./compare_viewer.js";
import { rendererStage } from "./three_renderer_stage.js";

offer(async (canvas, view) => {
  const renderer = new WebGPURenderer({ canvas, antialias: false });
  await renderer.init();
  return rendererStage(renderer, "isWebGPUBackend" in renderer.backend ? "webgpu" : "webgl", canvas, view);
});

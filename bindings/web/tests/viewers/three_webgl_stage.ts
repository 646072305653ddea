import { WebGLRenderer } from "three";
import { offer } from "./compare_viewer.js";
import { rendererStage } from "./three_renderer_stage.js";

offer(async (canvas, view) => rendererStage(new WebGLRenderer({ canvas, antialias: false }), "webgl", canvas, view));

// What a page and its worker say to each other. A page's messages have a number, and each is answered with it, in order.
import type { FaceContents } from "./contents.js";
import type { CharacterPose } from "./face.js";
import type { Source } from "./fetch_bytes.js";
import type { WasmSource } from "./instance.js";
import type { LoadLimits } from "./load_archive.js";
import type { Outputs } from "./model.js";
import type { RowBlock } from "./row_blocks.js";

export type Request =
  | { call: "load"; source: Source; wasm: WasmSource; limits: LoadLimits | undefined; progress: boolean }
  | { call: "evaluate"; controls: Float32Array; positions: Float32Array }
  | { call: "evaluateBatch"; controls: Float32Array; count: number; outputs: Outputs }
  | { call: "evaluateMany"; poses: readonly CharacterPose[] }
  | { call: "coefficients"; controls: Float32Array }
  | { call: "expectedError"; controls: Float32Array }
  | { call: "rowBlocks" }
  | { call: "dispose" };

export interface Results {
  load: FaceContents;
  evaluate: { controls: Float32Array; positions: Float32Array };
  evaluateBatch: { controls: Float32Array; outputs: Outputs };
  evaluateMany: Outputs[];
  coefficients: Float32Array;
  expectedError: { face: number; regions: Float32Array; outside: number };
  rowBlocks: readonly RowBlock[];
  dispose: null;
}

export interface Message {
  id: number;
  request: Request;
}

export type Answer =
  | { id: number; result: unknown }
  | { id: number; error: { message: string; status?: number; statusName?: string } }
  | { id: number; loaded: number; total: number };

const arrays = ["positions", "normals", "tangents", "sockets", "joints", "channels", "bounds", "expectedErrors",
                "outside"] as const;

/** The buffers of the arrays of outputs, to be moved instead of copied. */
export function outputBuffers(outputs: Outputs): ArrayBuffer[] {
  const buffers = new Set<ArrayBuffer>();
  for (const name of arrays) if (outputs[name]) buffers.add(outputs[name].buffer as ArrayBuffer);
  return [...buffers];
}

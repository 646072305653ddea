/** FaceBaker in the browser and in Node: loads a baked face and poses it, with the same bits as everywhere. */
export { FaceBakerError } from "./errors.js";
export { load } from "./load.js";
export { Face, type CharacterPose, type ExpectedError, type LoadOptions } from "./face.js";
export type { LoadLimits } from "./load_archive.js";
export { hasSimd, type WasmSource } from "./instance.js";
export type { Source } from "./fetch_bytes.js";
export type { EvaluateOptions, Outputs } from "./model.js";
export type { RowBlock } from "./row_blocks.js";
export { metresPerUnit } from "./units.js";
export * from "./contents.js";

// solver_urls.ts for CommonJS.
import { above } from "./asset_urls.js";

/** The WebAssembly module that solves, with SIMD or without. */
export function solverUrl(simd: boolean): URL {
  return above(simd ? "facebaker_solve.wasm" : "facebaker_solve-scalar.wasm");
}

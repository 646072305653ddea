// Where the module of the solver is; apart from the other files, so that bundlers copy it for pages that solve alone.
import { installedUrl, needMeta } from "./asset_urls.js";

/** The WebAssembly module that solves, with SIMD or without. */
export function solverUrl(simd: boolean): URL {
  needMeta("facebaker_solve.wasm");
  return installedUrl(simd ? new URL("./facebaker_solve.wasm", import.meta.url)
                           : new URL("./facebaker_solve-scalar.wasm", import.meta.url));
}

// asset_urls.ts for CommonJS, in dist/cjs: there the files are a folder above.
import { notRead } from "./errors.js";
import { isNode } from "./platform.js";

declare const __filename: string;

/** A file of the folder above. */
export function above(file: string): URL {
  if (!isNode)
    throw notRead(`${file}: CommonJS does not tell where it is; import facebaker as an ES module, or give \`load\` ` +
                  "the place of the file (docs/bundlers.md)");
  const path = /^[a-z]:/i.test(__filename) ? `/${__filename.replaceAll("\\", "/")}` : __filename; // Windows
  return new URL(`../${file}`, `file://${encodeURI(path).replace(/[?#]/g, encodeURIComponent)}`);
}

/** The WebAssembly module, with SIMD or without. */
export function wasmUrl(simd: boolean): URL {
  return above(simd ? "facebaker.wasm" : "facebaker-scalar.wasm");
}

/** The worker's script, for Node. */
export function workerUrl(): URL {
  return above("worker_main.js");
}

/** A worker of a browser. */
export function startWorker(): Worker {
  return new Worker(above("worker_main.js"));
}

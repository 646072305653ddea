// Where the files are that belong to the scripts. Each is spelled out, because bundlers look for
// new URL(literal, import.meta.url) and copy what it names.
import { notRead } from "./errors.js";

// Vite 6 and 7 serve packages in development as scripts of their own in node_modules/.vite/deps, without the files
// beside them, which are still where they were installed.
const bundled = "/node_modules/.vite/deps/", installed = "/node_modules/facebaker/dist/";

/** Next's URLs have no origin: nothing is made of those. */
export const installedUrl = (url: URL): URL =>
  url.href.includes(bundled) ? new URL(url.href.replace(bundled, installed)) : url;

/** Throws where scripts do not know where they are. */
export function needMeta(file: string): void {
  if (!import.meta.url)
    throw notRead(`${file}: these scripts were bundled into a format without import.meta.url; make ES modules of them, ` +
                  "or give `load` the place of the file (docs/bundlers.md)");
}

/** The WebAssembly module, with SIMD or without. */
export function wasmUrl(simd: boolean): URL {
  needMeta("facebaker.wasm");
  return installedUrl(simd ? new URL("./facebaker.wasm", import.meta.url) : new URL("./facebaker-scalar.wasm", import.meta.url));
}

/** The worker's script, for Node. */
export function workerUrl(): URL {
  return new URL("./worker_main.js", import.meta.url);
}

/** A worker of a browser. */
export function startWorker(): Worker {
  needMeta("worker_main.js");
  const moved = wasmUrl(true).href;
  if (new URL("./facebaker.wasm", import.meta.url).href !== moved)
    return new Worker(new URL("worker_main.js", moved), { type: "module" });
  return new Worker(new URL("./worker_main.js", import.meta.url), { type: "module" });
}

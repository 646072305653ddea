import { wasmUrl } from "./asset_urls.js";
import { loadWith, type Face, type LoadOptions } from "./face.js";
import type { Source } from "./fetch_bytes.js";
import { hasSimd } from "./instance.js";

/** Loads a face from a URL or from its bytes. Throws a FaceBakerError if it cannot be read or is not whole: the message
 * names the byte offset. */
export function load(source: Source, options: LoadOptions = {}): Promise<Face> {
  return loadWith(options.wasm ?? wasmUrl(options.simd ?? hasSimd()), source, options);
}

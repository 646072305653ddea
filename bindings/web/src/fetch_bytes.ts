// An archive's bytes, from wherever they are, with progress.
import { invalidArgument, notRead } from "./errors.js";
import { isNode, nodeModule } from "./platform.js";

export interface SignalOption {
  readonly signal?: AbortSignal | undefined;
}

export interface FetchOptions extends SignalOption {
  readonly progress?: ((loaded: number, total: number) => void) | undefined;
}

export type Source = string | URL | ArrayBuffer | Uint8Array;

async function readStream(answer: Response, options: FetchOptions): Promise<Uint8Array> {
  // What is compressed on the way has another length than it has here.
  const length = answer.headers.get("Content-Encoding") ? 0 : Number(answer.headers.get("Content-Length") ?? 0);
  if (!answer.body || !options.progress) return new Uint8Array(await answer.arrayBuffer());
  const reader = answer.body.getReader();
  const parts: Uint8Array[] = [];
  let loaded = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    parts.push(value);
    loaded += value.length;
    options.progress(loaded, Math.max(length, loaded));
  }
  const bytes = new Uint8Array(loaded);
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

/** Reads a source. A string is a URL, relative to the page; in Node it may be a path too. */
export async function fetchBytes(source: Source, options: FetchOptions): Promise<Uint8Array> {
  options.signal?.throwIfAborted();
  let bytes: Uint8Array;
  if (source instanceof Uint8Array) bytes = source;
  else if (source instanceof ArrayBuffer) bytes = new Uint8Array(source);
  else if (typeof source !== "string" && !(source instanceof URL))
    throw invalidArgument("load: the source is neither a URL, an ArrayBuffer nor a Uint8Array");
  else if (isNode && !/^(https?|data|blob):/.test(String(source))) {
    const { readFile } = await nodeModule("fs/promises");
    const { fileURLToPath } = await nodeModule("url");
    const path = String(source).startsWith("file:") ? fileURLToPath(String(source)) : String(source);
    bytes = await readFile(path).catch((error: Error) => {
      throw notRead(error.message);
    });
  } else {
    const answer = await fetch(source, options.signal ? { signal: options.signal } : {});
    if (!answer.ok) throw notRead(`${source}: the server answers ${answer.status} ${answer.statusText}`);
    return readStream(answer, options);
  }
  options.progress?.(bytes.length, bytes.length);
  return bytes;
}

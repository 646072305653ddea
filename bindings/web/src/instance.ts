// The WebAssembly module: finding, compiling and instantiating it. All faces of a variant share one instance, because
// browsers reserve gigabytes of addresses for the memory of each.
import { notRead } from "./errors.js";
import { isNode, nodeModule } from "./platform.js";

/** Pointers and sizes are unsigned 32-bit numbers; what the module returns has to be shifted by `>>> 0`. */
export type Exports = Record<string, (...values: (number | bigint)[]) => number> & { readonly memory: WebAssembly.Memory };

export type WasmSource = string | URL | BufferSource;

// A function that returns a vector.
const simdProbe = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 8, 1, 6, 0, 65, 0, 253, 15, 11,
]);

/** Whether this browser has WebAssembly SIMD. */
export function hasSimd(): boolean {
  return WebAssembly.validate(simdProbe);
}

// What the module imports. The C library asks for these where it would speak to a system; there is none: no
// environment, no files, and messages of the C++ library itself go to the console.
function imports(memory: () => WebAssembly.Memory): WebAssembly.Imports {
  const words = () => new DataView(memory().buffer);
  const badDescriptor = 8;
  return {
    env: { emscripten_notify_memory_growth: () => undefined },
    wasi_snapshot_preview1: {
      proc_exit: (code: number) => {
        throw new WebAssembly.RuntimeError(`facebaker.wasm ended with ${code}`);
      },
      environ_sizes_get: (count: number, size: number) => {
        words().setUint32(count, 0, true);
        words().setUint32(size, 0, true);
        return 0;
      },
      environ_get: () => 0,
      clock_time_get: (_clock: number, _precision: bigint, to: number) => {
        words().setBigUint64(to, BigInt(Math.round(Date.now() * 1e6)), true);
        return 0;
      },
      fd_close: () => badDescriptor,
      fd_read: () => badDescriptor,
      fd_seek: () => badDescriptor,
      fd_write: (descriptor: number, list: number, count: number, written: number) => {
        let text = "", bytes = 0;
        for (let i = 0; i < count; ++i) {
          const at = words().getUint32(list + 8 * i, true), size = words().getUint32(list + 8 * i + 4, true);
          text += new TextDecoder().decode(new Uint8Array(memory().buffer, at, size).slice());
          bytes += size;
        }
        words().setUint32(written, bytes, true);
        if (descriptor === 2 && text.trim()) console.error(text.trimEnd());
        return 0;
      },
    },
  };
}

const magic = [0, 97, 115, 109]; // "\0asm"
const remedy = "docs/bundlers.md says how each bundler is told of facebaker.wasm; the option `wasm` names another place";

async function compile(source: WasmSource): Promise<WebAssembly.Module> {
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return WebAssembly.compile(source as BufferSource);
  const address = source as string | URL;
  if (isNode && !/^(https?|data|blob):/.test(String(address))) {
    const { readFile } = await nodeModule("fs/promises");
    const { fileURLToPath } = await nodeModule("url");
    const path = String(address).startsWith("file:") ? fileURLToPath(String(address)) : String(address);
    return WebAssembly.compile(new Uint8Array(await readFile(path)));
  }
  const answer = await fetch(address);
  if (!answer.ok) throw notRead(`${address}: the server answers ${answer.status} ${answer.statusText}; ${remedy}`);
  // Servers that do not know the media type would have streaming fail.
  if (WebAssembly.compileStreaming && answer.headers.get("Content-Type")?.startsWith("application/wasm"))
    return WebAssembly.compileStreaming(answer);
  const bytes = await answer.arrayBuffer();
  // Some servers answer with their start page where there is no file.
  if (!magic.every((byte, i) => new Uint8Array(bytes)[i] === byte))
    throw notRead(`${address}: the server gives no WebAssembly module; ${remedy}`);
  return WebAssembly.compile(bytes);
}

async function instantiate(source: WasmSource): Promise<Exports> {
  let memory: WebAssembly.Memory | undefined;
  const module = await compile(source);
  const instance = await WebAssembly.instantiate(module, imports(() => memory as WebAssembly.Memory));
  const exports = instance.exports as unknown as Exports;
  memory = exports.memory;
  exports["_initialize"]?.();
  return exports;
}

const instances = new Map<unknown, Promise<Exports>>();

/** The instance of a module, made on first use. */
export function instanceOf(source: WasmSource): Promise<Exports> {
  const key = source instanceof URL ? source.href : source;
  let found = instances.get(key);
  if (!found) {
    found = instantiate(source);
    instances.set(key, found);
    found.catch(() => instances.delete(key)); // the next call tries again
  }
  return found;
}

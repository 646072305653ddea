// From the bytes of an archive to a model in the module's memory.
import { FaceBakerError, invalidArgument } from "./errors.js";
import type { Heap } from "./heap.js";

/** Limits for archives from strangers; beyond any of them loading fails with FB_ERROR_LIMIT. */
export interface LoadLimits {
  /** Memory that loading takes at any time. */
  modelBytes?: number;
  /** All names and texts. */
  nameBytes?: number;
  vertices?: number;
  polygons?: number;
  /** Functions of the controls that networks and sparse blendshapes are made of. */
  features?: number;
}

// The members of fb_load_desc.
const members: Record<keyof LoadLimits, string> = {
  modelBytes: "max_model_bytes", nameBytes: "max_name_bytes", vertices: "max_vertices", polygons: "max_polygons",
  features: "max_features",
};

/** The address of a model, which the caller has to release. */
export function loadArchive(heap: Heap, bytes: Uint8Array, limits: LoadLimits = {}): number {
  const struct = "fb_load_desc", desc = heap.allocate(heap.size(struct) + 8);
  const result = desc + heap.size(struct);
  let archive = 0;
  try {
    archive = heap.allocate(bytes.length);
    heap.u8.set(bytes, archive);
    heap.call("fb_load_desc_fill", desc, heap.size(struct));
    for (const [name, member] of Object.entries(members)) {
      const limit = limits[name as keyof LoadLimits];
      if (limit === undefined) continue;
      if (!(limit >= 0 && limit < 2 ** 32)) throw invalidArgument(`${member}: ${limit} is no size below 4 GiB`);
      heap.setU32(struct, desc, member, limit);
      heap.u32[((desc + heap.offset(struct, member)) >>> 2) + 1] = 0;
    }
    heap.check("fb_load_memory", archive, bytes.length, desc, result);
    return heap.u32[result >>> 2]!;
  } finally {
    if (archive) heap.release(archive);
    heap.release(desc);
  }
}

/** Does what may need much memory: what the module cannot get from the system ends it in the middle of a call. */
export function needMemory<Result>(work: () => Result): Result {
  try {
    return work();
  } catch (error) {
    if (error instanceof WebAssembly.RuntimeError)
      throw new FaceBakerError(13, "FB_ERROR_INTERNAL", `facebaker.wasm: ${error.message}`);
    throw error;
  }
}

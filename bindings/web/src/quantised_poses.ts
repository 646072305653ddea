// What a GPU computes positions of poses from, bit for bit: see "Poses for a GPU" in facebaker.h.
import { invalidArgument } from "./errors.js";
import type { Heap } from "./heap.js";
import type { Staging } from "./staging.js";

/** Arrays of what is computed of poses: each that is given is written, one pose after the other. */
export interface QuantisedOutputs {
  /** One a column of `rowBlocks`, row block after row block. */
  quantised?: Int16Array;
  /** One a row block; 0: it is at rest. */
  steps?: Float32Array;
  /** One an exact pose. */
  exactWeights?: Float32Array;
  /** 12 a driven joint: its frame. */
  joints?: Float32Array;
}

type ArrayName = keyof QuantisedOutputs;

// The members of fb_quantised_desc.
const members: Record<ArrayName, { size: string; pointer: string }> = {
  quantised: { pointer: "quantised", size: "quantised_numbers" },
  steps: { pointer: "steps", size: "step_floats" },
  exactWeights: { pointer: "exact_weights", size: "exact_weight_floats" },
  joints: { pointer: "joints", size: "joint_floats" },
};
const names = Object.keys(members) as ArrayName[];
const struct = "fb_quantised_desc";
const posesAtOnce = 64; // in the module's memory

/** Quantises poses of a model. */
export class Quantiser {
  private readonly sizes: Record<ArrayName, number>; // of one pose
  private readonly controls: Staging;
  private readonly outputs: Record<ArrayName, Staging>;

  /** staging: buffers by name, which it uses in turn with others and does not free. */
  constructor(private readonly heap: Heap, model: number, private readonly controlCount: number,
              staging: (name: string) => Staging) {
    const count = (name: string) => heap.call(name, model);
    this.sizes = { quantised: count("fb_digit_column_count"), steps: count("fb_row_block_count"),
                   exactWeights: count("fb_exact_pose_count"), joints: 12 * count("fb_driven_joint_count") };
    this.controls = staging("controls");
    this.outputs = { quantised: staging("quantised"), steps: staging("steps"), exactWeights: staging("exactWeights"),
                     joints: staging("joints") };
  }

  quantise(model: number, scratch: number, controls: Float32Array, count: number, outputs: QuantisedOutputs): void {
    if (!(controls instanceof Float32Array) || controls.length < count * this.controlCount)
      throw invalidArgument(`controls: ${controls?.length} numbers, but ${count * this.controlCount} are needed`);
    for (const name of names) {
      const array = outputs[name], needed = count * this.sizes[name];
      if (array && array.length < needed)
        throw invalidArgument(`${name}: ${array.length} numbers, but ${needed} are needed`);
    }
    const { heap } = this, desc = heap.allocate(heap.size(struct));
    try {
      for (let first = 0; first < count; first += posesAtOnce)
        this.quantiseSome(model, scratch, desc, controls, first, Math.min(posesAtOnce, count - first), outputs);
    } finally {
      heap.release(desc);
    }
  }

  private quantiseSome(model: number, scratch: number, desc: number, controls: Float32Array, first: number, count: number,
                       outputs: QuantisedOutputs): void {
    const { heap, sizes, controlCount } = this;
    this.controls.reserve(count * controlCount);
    for (const name of names) if (outputs[name]) this.outputs[name].reserve(Math.max(1, count * sizes[name]));
    heap.call(`${struct}_fill`, desc, heap.size(struct));
    this.controls.floats(count * controlCount).set(controls.subarray(first * controlCount, (first + count) * controlCount));
    heap.setU32(struct, desc, "poses", count);
    heap.setU32(struct, desc, "controls", this.controls.address);
    heap.setU32(struct, desc, "control_floats", count * controlCount);
    for (const name of names) {
      if (!outputs[name]) continue;
      heap.setU32(struct, desc, members[name].pointer, this.outputs[name].address);
      heap.setU32(struct, desc, members[name].size, count * sizes[name]);
    }
    heap.check("fb_evaluate_quantised", model, scratch, desc);
    for (const name of names) outputs[name]?.set(this.view(name, count * sizes[name]), first * sizes[name]);
  }

  private view(name: ArrayName, length: number): Float32Array | Int16Array {
    if (name !== "quantised") return this.outputs[name].floats(length);
    return new Int16Array(this.heap.exports.memory.buffer, this.outputs.quantised.address, length);
  }
}

// A buffer in the module's memory, which grows with what is put into it.
import type { Heap } from "./heap.js";

type Numbers = Float32Array | Uint32Array | Uint8Array;

/** Keeps its view until the memory grows or another length is asked for. */
export class Staging {
  address = 0;
  private capacity = 0;
  private view: Numbers | null = null;

  constructor(private readonly heap: Heap) {}

  /** Room for so many numbers of four bytes. */
  reserve(length: number): void {
    if (length <= this.capacity) return;
    this.release();
    this.address = this.heap.allocate(4 * length);
    this.capacity = length;
  }
  floats(length: number): Float32Array {
    if (!(this.view instanceof Float32Array) || this.view.length !== length)
      this.view = new Float32Array(this.heap.exports.memory.buffer, this.address, length);
    return this.view;
  }
  numbers(length: number): Uint32Array {
    if (!(this.view instanceof Uint32Array) || this.view.length !== length)
      this.view = new Uint32Array(this.heap.exports.memory.buffer, this.address, length);
    return this.view;
  }
  bytes(length: number): Uint8Array {
    if (!(this.view instanceof Uint8Array) || this.view.length !== length)
      this.view = new Uint8Array(this.heap.exports.memory.buffer, this.address, length);
    return this.view;
  }
  release(): void {
    if (this.address) this.heap.release(this.address);
    this.address = this.capacity = 0;
    this.view = null;
  }
}

// Buffers in the module's memory, which grow with what is put into them.
import type { Heap } from "./heap.js";

type Numbers = Float32Array | Uint32Array | Uint8Array;

/** The memory of a buffer, which several may use in turn. */
export class Room {
  address = 0;
  private capacity = 0;

  constructor(private readonly heap: Heap) {}

  /** Makes room for so many numbers of four bytes. */
  reserve(length: number): void {
    if (length <= this.capacity) return;
    this.release();
    this.address = this.heap.allocate(4 * length);
    this.capacity = length;
  }
  release(): void {
    if (this.address) this.heap.release(this.address);
    this.address = this.capacity = 0;
  }
}

/** A buffer as numbers. Keeps its view until the memory grows, the room moves or another length is asked for. */
export class Staging {
  private view: Numbers | null = null;

  constructor(private readonly heap: Heap, private readonly room = new Room(heap)) {}

  get address(): number {
    return this.room.address;
  }
  /** Room for so many numbers of four bytes. */
  reserve(length: number): void {
    this.room.reserve(length);
  }
  floats(length: number): Float32Array {
    const { view } = this;
    if (view instanceof Float32Array && this.holds(view, length)) return view;
    return (this.view = new Float32Array(this.heap.exports.memory.buffer, this.address, length));
  }
  numbers(length: number): Uint32Array {
    const { view } = this;
    if (view instanceof Uint32Array && this.holds(view, length)) return view;
    return (this.view = new Uint32Array(this.heap.exports.memory.buffer, this.address, length));
  }
  bytes(length: number): Uint8Array {
    const { view } = this;
    if (view instanceof Uint8Array && this.holds(view, length)) return view;
    return (this.view = new Uint8Array(this.heap.exports.memory.buffer, this.address, length));
  }
  release(): void {
    this.room.release();
    this.view = null;
  }

  // Of memory that has grown since, a view has length and offset 0.
  private holds(view: Numbers, length: number): boolean {
    return view.length === length && view.byteOffset === this.room.address;
  }
}

// Arrays that a struct of the library points to: copies in the module's memory, one buffer for each member.
import { invalidArgument } from "./errors.js";
import type { Heap } from "./heap.js";
import { Staging } from "./staging.js";

type Numbers = Float32Array | Uint32Array | Uint8Array;

export class StructArrays {
  private readonly buffers = new Map<string, Staging>();
  private address = 0;

  constructor(private readonly heap: Heap, private readonly struct: string) {}

  /** The struct with its defaults. */
  begin(): number {
    const { heap, struct } = this, size = heap.size(struct);
    if (this.address === 0) this.address = heap.allocate(size);
    heap.call(`${struct}_fill`, this.address, size);
    return this.address;
  }

  setU32(member: string, value: number): void {
    this.heap.setU32(this.struct, this.address, member, value);
  }
  /** Undefined leaves the default. */
  setF32(member: string, value: number | undefined): void {
    if (value !== undefined) this.heap.setF32(this.struct, this.address, member, value);
  }

  /** Points a member to a copy of `count` numbers; without an array it stays null. */
  put(member: string, array: Numbers | undefined, count: number): void {
    if (!array) return;
    if (array.length < count) throw invalidArgument(`${member}: ${array.length} numbers, but ${count} are needed`);
    this.view(member, array, count).set(array.length === count ? array : array.subarray(0, count));
  }

  /** Copies what was written behind a member. */
  get(member: string, array: Numbers | undefined, count: number): void {
    array?.set(this.view(member, array, count));
  }

  /** What is behind a member, as numbers of the kind of `like`; made where there is no such buffer. */
  view(member: string, like: Numbers, count: number): Numbers {
    let buffer = this.buffers.get(member);
    if (!buffer) this.buffers.set(member, (buffer = new Staging(this.heap)));
    buffer.reserve(Math.max(count, 1));
    this.setU32(member, buffer.address);
    if (like instanceof Float32Array) return buffer.floats(count);
    return like instanceof Uint32Array ? buffer.numbers(count) : buffer.bytes(count);
  }

  release(): void {
    for (const buffer of this.buffers.values()) buffer.release();
    if (this.address) this.heap.release(this.address);
    this.address = 0;
  }
}

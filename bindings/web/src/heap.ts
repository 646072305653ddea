// The memory of an instance: views, strings and structs in it.
import { FaceBakerError } from "./errors.js";
import type { Exports } from "./instance.js";
import { structLayouts } from "./struct_layouts.js";

type Kind = "u32" | "u64" | "f32" | "f64" | "text" | "pointer";
type Member = readonly [offset: number, kind: Kind, count?: number];

/** Where the members of a struct are: `kind` is that of an array's elements, "text" a pointer to a string. */
export interface Layout {
  readonly size: number;
  readonly members: Readonly<Record<string, Member>>;
}

/** A struct as it is read, by the names of its members: strings are decoded, pointers are addresses. */
export type StructValues = Record<string, any>;

export class Heap {
  /** These are made anew when the memory has grown. */
  u8!: Uint8Array;
  u32!: Uint32Array;
  f32!: Float32Array;
  private readonly decoder = new TextDecoder();

  constructor(readonly exports: Exports) {
    this.refresh();
  }

  /** Looks at the memory again; to be called after anything that may allocate. */
  refresh(): void {
    if (this.u8?.buffer === this.exports.memory.buffer) return;
    const { buffer } = this.exports.memory;
    this.u8 = new Uint8Array(buffer);
    this.u32 = new Uint32Array(buffer);
    this.f32 = new Float32Array(buffer);
  }

  /** Calls a function that returns a pointer or a count. */
  call(name: string, ...values: number[]): number {
    const result = this.exports[name]!(...values);
    this.refresh();
    return Number(result) >>> 0;
  }

  /** Calls a function that returns a status, and throws if it is not FB_OK. */
  check(name: string, ...values: (number | bigint)[]): void {
    const status = this.exports[name]!(...values);
    this.refresh();
    if (status !== 0) this.fail(status);
  }

  fail(status: number): never {
    const name = this.text(this.exports["fb_status_name"]!(status));
    throw new FaceBakerError(status, name, this.text(this.exports["fb_last_error"]!()));
  }

  allocate(bytes: number): number {
    const address = bytes < 0x7fffffff ? this.call("malloc", Math.max(bytes, 1)) : 0;
    if (address === 0) throw new FaceBakerError(8, "FB_ERROR_OUT_OF_MEMORY", `there is no memory for ${bytes} bytes`);
    return address;
  }

  release(address: number): void {
    this.exports["free"]!(address);
  }

  /** The string at an address; "" for null. */
  text(address: number): string {
    address >>>= 0;
    if (address === 0) return "";
    return this.decoder.decode(this.u8.slice(address, this.u8.indexOf(0, address)));
  }

  /** Calls with the address of a string, which is freed afterwards. */
  withText<Result>(text: string, use: (address: number) => Result): Result {
    const bytes = new TextEncoder().encode(text);
    const address = this.allocate(bytes.length + 1);
    this.u8.set(bytes, address);
    this.u8[address + bytes.length] = 0;
    try {
      return use(address);
    } finally {
      this.release(address);
    }
  }

  /** Copies of arrays; empty for null. */
  copyU8(address: number, count: number): Uint8Array {
    return address ? this.u8.slice(address, address + count) : new Uint8Array(0);
  }
  copyU16(address: number, count: number): Uint16Array {
    return address ? new Uint16Array(this.u8.slice(address, address + 2 * count).buffer) : new Uint16Array(0);
  }
  copyU32(address: number, count: number): Uint32Array {
    return address ? this.u32.slice(address >>> 2, (address >>> 2) + count) : new Uint32Array(0);
  }
  copyF32(address: number, count: number): Float32Array {
    return address ? this.f32.slice(address >>> 2, (address >>> 2) + count) : new Float32Array(0);
  }

  size(struct: string): number {
    return structLayouts[struct]!.size;
  }
  offset(struct: string, member: string): number {
    return structLayouts[struct]!.members[member]![0];
  }

  /** The struct at an address. */
  read(struct: string, address: number): StructValues {
    const values: StructValues = {};
    for (const [name, [offset, kind, count]] of Object.entries(structLayouts[struct]!.members)) {
      const at = (address + offset) >>> 2;
      if (kind === "f32") values[name] = count ? Array.from(this.f32.subarray(at, at + count)) : this.f32[at];
      else if (kind === "text") values[name] = this.text(this.u32[at]!);
      else if (kind === "f64") values[name] = new DataView(this.u8.buffer).getFloat64(address + offset, true);
      else if (kind === "u64") values[name] = this.u32[at]! + 2 ** 32 * this.u32[at + 1]!;
      else values[name] = this.u32[at];
    }
    return values;
  }

  /** Calls fb_STRUCT_fill and a function that fills the struct further, and reads it. */
  fill(struct: string, fill: (address: number) => void): StructValues {
    const address = this.allocate(this.size(struct));
    try {
      this.call(`${struct}_fill`, address, this.size(struct));
      fill(address);
      return this.read(struct, address);
    } finally {
      this.release(address);
    }
  }

  /** Sets a member that is a pointer, a count or a number; of 64-bit members the lower half. */
  setU32(struct: string, address: number, member: string, value: number): void {
    this.u32[(address + this.offset(struct, member)) >>> 2] = value;
  }
  setF32(struct: string, address: number, member: string, value: number): void {
    this.f32[(address + this.offset(struct, member)) >>> 2] = value;
  }
}

const heaps = new WeakMap<Exports, Heap>();

/** The memory of an instance. */
export function heapOf(exports: Exports): Heap {
  let heap = heaps.get(exports);
  if (!heap) heaps.set(exports, (heap = new Heap(exports)));
  return heap;
}

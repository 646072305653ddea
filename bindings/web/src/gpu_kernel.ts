// Buffers and compute pipelines of a device, within its limits.

/** Limits of a device, by WebGPU's names. */
export interface GpuLimits {
  maxComputeWorkgroupsPerDimension: number;
  maxStorageBufferBindingSize: number;
}

// WebGPU's numbers: Node has no GPUBufferUsage of its own.
const usage = { copySource: 4, copyTarget: 8, vertex: 32, uniform: 64, storage: 128 };
export const vertexUse = usage.vertex | usage.copySource;

/** A part of a buffer, bound from an aligned byte on; `number` is the first of its numbers from there. */
export interface BoundPart {
  readonly buffer: GPUBuffer;
  readonly offset: number;
  readonly size: number;
  readonly number: number;
}

/** The arrays of shaders. */
export class GpuArrays {
  readonly limits: GpuLimits & { readonly alignment: number };
  private readonly owned = new Set<GPUBuffer>();
  private readonly written = new Map<string, GPUBuffer>(); // by name, as large as was ever needed

  constructor(readonly device: GPUDevice, lower: Partial<GpuLimits> = {}) {
    const least = (name: keyof GpuLimits) => Math.min(device.limits[name], lower[name] ?? Infinity);
    this.limits = { maxComputeWorkgroupsPerDimension: least("maxComputeWorkgroupsPerDimension"),
                    maxStorageBufferBindingSize: Math.min(least("maxStorageBufferBindingSize"), device.limits.maxBufferSize),
                    alignment: device.limits.minStorageBufferOffsetAlignment };
  }

  /** A buffer that shaders read and write, and that is the caller's. */
  create(size: number, use = 0): GPUBuffer {
    return this.device.createBuffer({ size: Math.max(size, 16), usage: usage.storage | usage.copyTarget | use });
  }

  /** An array that stays. `what`: "basis". */
  upload(what: string, words: Uint32Array): GPUBuffer {
    const most = this.limits.maxStorageBufferBindingSize;
    if (words.byteLength > most)
      throw new RangeError(`the ${what} takes ${words.byteLength} bytes; this device binds at most ${most}`);
    const buffer = this.create(words.byteLength);
    this.owned.add(buffer);
    this.device.queue.writeBuffer(buffer, 0, words);
    return buffer;
  }

  /** An array of a call. */
  write(name: string, words: Uint32Array, use = 0): GPUBuffer {
    let buffer = this.written.get(name);
    if (!buffer || buffer.size < words.byteLength) {
      buffer?.destroy();
      this.written.set(name, (buffer = this.create(words.byteLength, use)));
    }
    this.device.queue.writeBuffer(buffer, 0, words);
    return buffer;
  }

  writeUniform(name: string, words: Uint32Array): GPUBuffer {
    return this.write(name, words, usage.uniform);
  }

  bind(buffer: GPUBuffer, offset: number, size: number): BoundPart {
    const aligned = offset - (offset % this.limits.alignment);
    return { buffer, offset: aligned, size: size + offset - aligned, number: (offset - aligned) / 4 };
  }

  dispose(): void {
    for (const buffer of [...this.owned, ...this.written.values()]) buffer.destroy();
    this.owned.clear();
    this.written.clear();
  }
}

const slotWords = 64; // of the parameters of a dispatch: where the next may begin

let kernels = 0;

/** A compute shader: parameters, then arrays that it reads or writes. */
export class Kernel {
  private readonly pipeline: GPUComputePipeline;
  private readonly layout: GPUBindGroupLayout;
  private readonly name = `parameters ${kernels++}`;

  constructor(private readonly arrays: GpuArrays, code: string, access: readonly ("read" | "write")[]) {
    const { device } = arrays, visibility = 4; // compute
    this.layout = device.createBindGroupLayout({ entries: [
      { binding: 0, visibility, buffer: { type: "uniform", hasDynamicOffset: true } },
      ...access.map((of, i) => ({ binding: i + 1, visibility,
                                  buffer: { type: of === "read" ? "read-only-storage" : "storage" } as const })),
    ] });
    this.pipeline = device.createComputePipeline({
      layout: device.createPipelineLayout({ bindGroupLayouts: [this.layout] }),
      compute: { module: device.createShaderModule({ code }) },
    });
  }

  /** Runs it on a grid of workgroups, in several dispatches where the device takes fewer at once. parametersAt(x, y):
   * those of the dispatch that begins there. */
  encode(encoder: GPUCommandEncoder, arrays: readonly (GPUBuffer | BoundPart)[], [width, height]: readonly [number, number],
         parametersAt: (x: number, y: number) => readonly number[]): void {
    const most = this.arrays.limits.maxComputeWorkgroupsPerDimension, dispatches: [number, number, number, number][] = [];
    for (let y = 0; y < height; y += most)
      for (let x = 0; x < width; x += most)
        dispatches.push([x, y, Math.min(most, width - x), Math.min(most, height - y)]);
    const words = new Uint32Array(slotWords * Math.max(dispatches.length, 1));
    dispatches.forEach(([x, y], i) => words.set(parametersAt(x, y), slotWords * i));
    const size = 4 * parametersAt(0, 0).length;
    const group = this.arrays.device.createBindGroup({ layout: this.layout, entries: [
      { binding: 0, resource: { buffer: this.arrays.writeUniform(this.name, words), size } },
      ...arrays.map((array, i) => ({ binding: i + 1, resource: "buffer" in array ?
        { buffer: array.buffer, offset: array.offset, size: array.size } : { buffer: array } })),
    ] });
    const pass = encoder.beginComputePass();
    pass.setPipeline(this.pipeline);
    dispatches.forEach(([, , columns, rows], i) => {
      pass.setBindGroup(0, group, [4 * slotWords * i]);
      pass.dispatchWorkgroups(columns, rows);
    });
    pass.end();
  }
}

/** A face whose poses a GPU computes, by compute passes of WebGPU, with the very bits of Face.evaluate: the processor
 * quantises the coefficients of each pose, the GPU takes sums of whole numbers, and rounds their positions with whole
 * numbers, too. So nothing is left to drivers. Only where driven joints then move vertices do floats differ by
 * rounding. */
import { digitSumsShader, panelWords, parameterNames, posesOfOctet, workgroupSize,
         type SumParameters } from "./digit_sums_shader.js";
import { inverseOf, writeChange } from "./driven_matrices.js";
import type { Face } from "./face.js";
import { FactorPacker } from "./gpu_factors.js";
import { GpuArrays, Kernel, vertexUse, type GpuLimits } from "./gpu_kernel.js";
import { packDigits } from "./packed_digits.js";
import { jointNumbers, skinParameterNames, skinShader } from "./skin_shader.js";

export interface GpuEvaluatorOptions {
  /** The order in which vertices are written; "source" by default. */
  vertexOrder?: "source" | "baked";
  /** Whether shaders use WGSL's dot4I8Packed; by default where the browser has it. Positions are the same. */
  integerDot?: boolean;
  /** Limits to keep within, where they are below the device's. */
  limits?: Partial<GpuLimits>;
}

export interface GpuPoseOptions {
  /** Byte of the buffer at which positions begin, a multiple of 4; 0 by default. */
  offset?: number;
  /** Displacements from the rest pose in place of positions, before driven joints move vertices. */
  displacements?: boolean;
  /** Positions before driven joints move vertices. */
  unskinned?: boolean;
}

const hasIntegerDot = (): boolean =>
  (globalThis as { navigator?: Navigator }).navigator?.gpu?.wgslLanguageFeatures
    .has("packed_4x8_integer_dot_product") ?? false;

const mostFactorBytes = 1 << 27; // of the poses of a dispatch, in the processor's memory

/** Poses one face many times. Its arrays lie on the device until `dispose`. */
export class GpuEvaluator {
  /** Bytes on the GPU: of the basis, of the rest mesh with what stands beside it, of the skin of driven joints. */
  readonly bytes: { readonly basis: number; readonly rest: number; readonly skin: number };
  private readonly arrays: GpuArrays;
  private readonly packer: FactorPacker;
  private readonly sums: Kernel;
  private readonly skin: Kernel | null;
  private readonly basis: GPUBuffer;
  private readonly rest: GPUBuffer;
  private readonly influences: GPUBuffer | null = null;
  private readonly panelCount: number;
  private readonly inverses: readonly number[][]; // of the frames of driven joints at rest
  private quantised = new Int16Array(0);
  private steps: Float32Array = new Float32Array(0);
  private weights: Float32Array = new Float32Array(0);
  private frames: Float32Array = new Float32Array(0);

  constructor(private readonly device: GPUDevice, private readonly face: Face, options: GpuEvaluatorOptions = {}) {
    const { integerDot = hasIntegerDot(), vertexOrder = "source" } = options;
    this.arrays = new GpuArrays(device, options.limits);
    const order = placesOf(face, vertexOrder), basis = layOutPanels(face), rest = layOutRest(face, basis.panels, order);
    this.panelCount = basis.panels.length;
    this.packer = new FactorPacker(face.rowBlocks, face.exactPoses.length);
    this.sums = new Kernel(this.arrays, digitSumsShader(integerDot), ["read", "read", "read", "read", "write"]);
    this.basis = this.arrays.upload("basis", basis.words);
    this.rest = this.arrays.upload("rest mesh", rest);
    this.inverses = face.drivenJoints.map((joint) => inverseOf(joint.rest));
    this.skin = face.drivenSkin ? new Kernel(this.arrays, skinShader, ["read", "read", "write"]) : null;
    if (this.skin) this.influences = this.arrays.upload("skin of driven joints", layOutInfluences(face, order));
    this.bytes = { basis: this.basis.size, rest: this.rest.size, skin: this.influences?.size ?? 0 };
  }

  /** Bytes of the positions of so many poses: 12 a vertex. */
  bytesOf(poses: number): number {
    return 12 * this.face.vertexCount * poses;
  }

  /** A buffer for the positions of so many poses, to be written here, drawn from and copied. */
  createBuffer(poses: number): GPUBuffer {
    const { maxBufferSize } = this.device.limits, most = Math.floor(maxBufferSize / this.bytesOf(1));
    if (poses > most)
      throw new RangeError(`${poses} poses take ${this.bytesOf(poses)} bytes; a buffer of this device has at most ` +
                           `${maxBufferSize}, which is ${most} poses`);
    return this.arrays.create(this.bytesOf(poses), vertexUse);
  }

  /** Poses the face `count` times; controls and positions of the poses follow each other: vertex v of pose p is three
   * floats at byte offset + 12 * (p * vertexCount + v). Submits the work and returns; what the queue is given later sees
   * the positions. */
  evaluate(controls: Float32Array, count: number, to: GPUBuffer, options: GpuPoseOptions = {}): void {
    const { offset = 0 } = options, needed = offset + this.bytesOf(count);
    if (offset % 4 !== 0) throw new RangeError(`offset: ${offset} is not a multiple of 4`);
    if (to.size < needed) throw new RangeError(`${count} poses need a buffer of ${needed} bytes; it has ${to.size}`);
    const most = this.posesAtOnce();
    for (let first = 0; first < count; first += most) {
      const poses = Math.min(most, count - first), { controlCount } = this.face;
      this.evaluateSome(controls.subarray(first * controlCount, (first + poses) * controlCount), poses, to,
                        offset + this.bytesOf(first), options);
    }
  }

  // As many poses as the buffers of a chunk can have.
  private posesAtOnce(): number {
    const { maxStorageBufferBindingSize: most, alignment } = this.arrays.limits;
    const written = Math.floor((most - alignment) / this.bytesOf(1)), joints = 4 * jointNumbers * this.inverses.length;
    if (written < 1)
      throw new RangeError(`a pose takes ${this.bytesOf(1)} bytes; this device binds at most ${most - alignment}`);
    const octets = Math.floor((Math.min(most, mostFactorBytes) - 4) / (this.packer.mostBytes(1) - 4));
    if (octets < 1)
      throw new RangeError(`the factors of eight poses take ${this.packer.mostBytes(1)} bytes; this device binds at most ` +
                           `${most}`);
    return Math.min(written, posesOfOctet * octets, joints > 0 ? Math.floor(most / joints) : Infinity);
  }

  private evaluateSome(controls: Float32Array, poses: number, to: GPUBuffer, offset: number, options: GpuPoseOptions): void {
    const { face, arrays, device } = this, moved = this.skin !== null && !options.unskinned && !options.displacements;
    this.reserve(poses, moved);
    const { quantised, steps, weights: exactWeights, frames: joints } = this;
    const exact = face.exactPoses.length;
    face.quantise(controls, poses, { quantised, steps, ...(exact ? { exactWeights } : {}), ...(moved ? { joints } : {}) });
    const { octets, lists, factors, quads } = this.packer.pack({ quantised, steps, exactWeights }, poses);
    const target = arrays.bind(to, offset, this.bytesOf(poses));
    const parameters: Omit<SumParameters, "first_panel" | "first_octet"> = {
      poses, blocks: face.rowBlocks.length, panels: this.panelCount, exact, vertices: face.vertexCount, octets, quads,
      first_number: target.number, displacements: options.displacements ? 1 : 0, unused: 0 };
    const encoder = device.createCommandEncoder();
    this.sums.encode(encoder, [this.basis, this.rest, arrays.write("lists", lists), arrays.write("factors", factors), target],
                     [this.panelCount, octets], (x, y) => {
      const all: SumParameters = { ...parameters, first_panel: x, first_octet: y };
      return parameterNames.map((name) => all[name]);
    });
    if (moved) this.encodeSkin(encoder, poses, target);
    device.queue.submit([encoder.finish()]);
  }

  private encodeSkin(encoder: GPUCommandEncoder, poses: number, target: ReturnType<GpuArrays["bind"]>): void {
    const { face, frames, inverses } = this, { vertexCount } = face, size = jointNumbers * inverses.length;
    for (let pose = 0; pose < poses; ++pose)
      face.drivenJoints.forEach(({ rest }, joint) =>
        writeChange(frames, rest, inverses[joint]!, pose * size + jointNumbers * joint));
    const joints = this.arrays.write("joints", new Uint32Array(frames.buffer, 0, poses * size));
    this.skin!.encode(encoder, [this.influences!, joints, target], [Math.ceil(vertexCount / workgroupSize), poses], (x, y) => {
      const all = { vertices: vertexCount, influences: face.drivenSkin!.influences, joints: inverses.length, first_pose: y,
                    first_number: target.number, first_vertex: workgroupSize * x, unused: 0, unused_too: 0 };
      return skinParameterNames.map((name) => all[name]);
    });
  }

  private reserve(poses: number, moved: boolean): void {
    const columns = this.face.rowBlocks.reduce((sum, block) => sum + block.columns.length, 0);
    if (this.quantised.length < poses * columns) this.quantised = new Int16Array(poses * columns);
    const floats = (array: Float32Array, length: number) =>
      array.length < length ? new Float32Array(length) : array;
    this.steps = floats(this.steps, poses * this.face.rowBlocks.length);
    this.weights = floats(this.weights, poses * this.face.exactPoses.length);
    if (moved) this.frames = floats(this.frames, poses * jointNumbers * this.inverses.length);
  }

  /** Frees what it has on the GPU. */
  dispose(): void {
    this.arrays.dispose();
  }
}

// Where each vertex in baked order is written.
function placesOf(face: Face, vertexOrder: "source" | "baked"): Uint32Array {
  if (vertexOrder === "source" && face.vertexOrder) return face.vertexOrder;
  return Uint32Array.from({ length: face.vertexCount }, (_, vertex) => vertex);
}

function layOutPanels(face: Face) {
  const { panels, words } = packDigits(face.rowBlocks), all = new Uint32Array(panelWords * panels.length + words.length);
  panels.forEach(({ firstRow, rowCount, block, headers }, i) => all.set([firstRow, rowCount, block, headers], panelWords * i));
  all.set(words, panelWords * panels.length);
  return { panels, words: all };
}

// Bits of the rest mesh in the order of rows, places, where corrections begin, corrections.
function layOutRest(face: Face, panels: ReturnType<typeof packDigits>["panels"], places: Uint32Array): Uint32Array {
  const { vertexCount, vertexOrder, restPositions, exactCorrections } = face, starts: number[] = [], floats: number[] = [];
  const begin = 4 * vertexCount + exactCorrections.length * panels.length;
  for (const blocks of exactCorrections)
    for (const { block, firstRow, rowCount } of panels) {
      const rows = blocks[block], first = firstRow - face.rowBlocks[block]!.firstRow;
      starts.push(rows ? begin + floats.length : 0);
      if (rows) for (let row = first; row < first + rowCount; ++row) floats.push(rows[row]!);
    }
  const words = new Uint32Array(begin + floats.length), rest = new Uint32Array(restPositions.buffer, restPositions.byteOffset);
  for (let vertex = 0; vertex < vertexCount; ++vertex) {
    const source = vertexOrder ? vertexOrder[vertex]! : vertex;
    for (let axis = 0; axis < 3; ++axis) words[3 * vertex + axis] = rest[3 * source + axis]!;
  }
  words.set(places, 3 * vertexCount);
  words.set(starts, 4 * vertexCount);
  new Float32Array(words.buffer).set(floats, begin);
  return words;
}

// By vertex as it is written: joint and weight of its influences.
function layOutInfluences(face: Face, places: Uint32Array): Uint32Array {
  const { influences, joints, weights } = face.drivenSkin!, words = new Uint32Array(2 * influences * face.vertexCount);
  const floats = new Float32Array(words.buffer);
  for (let vertex = 0; vertex < face.vertexCount; ++vertex) {
    const source = face.vertexOrder ? face.vertexOrder[vertex]! : vertex;
    for (let i = 0; i < influences; ++i) {
      const at = 2 * (influences * places[vertex]! + i);
      words[at] = joints[influences * source + i]!;
      floats[at + 1] = weights[influences * source + i]!;
    }
  }
  return words;
}

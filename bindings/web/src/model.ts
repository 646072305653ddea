// A loaded model with its scratches, in the module's memory.
import { invalidArgument } from "./errors.js";
import type { Heap } from "./heap.js";
import type { Exports } from "./instance.js";
import { PoseRooms } from "./pose_rooms.js";
import { Quantiser, type QuantisedOutputs } from "./quantised_poses.js";
import { Staging } from "./staging.js";

export interface EvaluateOptions {
  /** Level of detail: 0 is the whole, 1, 2, ... the levels; positions are continuous in it. */
  lod?: number;
  /** Only the vertices of the level are written, the first in baked order; needs `vertexOrder: "baked"`. */
  levelOnly?: boolean;
  /** The order in which vertices are written; "source" by default. */
  vertexOrder?: "source" | "baked";
  /** Displacements from the rest pose in place of positions, before driven joints move vertices. */
  displacements?: boolean;
  /** Positions, normals and tangents before driven joints move vertices, for a host that skins by itself. */
  unskinned?: boolean;
  /** Indices of the meshes that are posed; the vertices of the others are left as they are. All by default. */
  meshes?: readonly number[];
  /** Indices of the regions whose networks run, see `networkRegions`. All by default. */
  regions?: readonly number[];
}

/** What is computed of a pose: each array that is given is written. Several poses follow each other in each. */
export interface Outputs extends EvaluateOptions {
  /** 3 a vertex. */
  positions?: Float32Array;
  /** 3 a vertex, unit length. */
  normals?: Float32Array;
  /** 3 a vertex, unit length; of faces with texture coordinates. */
  tangents?: Float32Array;
  /** 12 a socket: the upper three rows of a 4 x 4 matrix, row after row. */
  sockets?: Float32Array;
  /** 12 a driven joint: its frame, the upper three rows of a 4 x 4 matrix, row after row, in the space of positions. */
  joints?: Float32Array;
  /** One a channel. */
  channels?: Float32Array;
  /** 6: the smallest x, y and z, then the largest. */
  bounds?: Float32Array;
  /** 1 + regions.names.length: of the whole face, then of each region. */
  expectedErrors?: Float32Array;
  /** 1: how many controls are outside of what was trained. */
  outside?: Uint32Array;
}

type ArrayName =
  "positions" | "normals" | "tangents" | "sockets" | "joints" | "channels" | "bounds" | "expectedErrors" | "outside";

// The members of fb_batch_desc for each output: address, size and stride between poses.
const members: Record<ArrayName, { pointer: string; size?: string; stride?: string }> = {
  positions: { pointer: "positions", size: "position_floats", stride: "pose_stride" },
  normals: { pointer: "normals", size: "normal_numbers", stride: "normal_pose_stride" },
  tangents: { pointer: "tangents", size: "tangent_numbers", stride: "tangent_pose_stride" },
  sockets: { pointer: "sockets", size: "socket_floats", stride: "socket_pose_stride" },
  joints: { pointer: "joints", size: "joint_floats", stride: "joint_pose_stride" },
  channels: { pointer: "channels", size: "channel_floats", stride: "channel_pose_stride" },
  bounds: { pointer: "bounds", size: "bounds_floats", stride: "bounds_pose_stride" },
  expectedErrors: { pointer: "expected_errors", size: "expected_error_floats", stride: "expected_error_pose_stride" },
  outside: { pointer: "outside" },
};
const names = Object.keys(members) as ArrayName[];

const bytesAtOnce = 4 << 20; // of a batch's outputs in the module's memory

export class Model {
  readonly vertexCount: number;
  readonly controlCount: number;
  readonly coefficientCount: number;
  private readonly sizes: Record<ArrayName, number>; // of one pose
  private sizesOfLevels: Record<ArrayName, number>[] | null = null;
  private readonly evaluateCall: Exports[string];
  private readonly evaluateBatchCall: Exports[string];
  private readonly fillDescCall: Exports[string];
  private readonly descSize: number;
  private readonly rooms: PoseRooms;
  private scratch = 0;
  private batchScratch = 0; // with room to evaluate several poses together, once there is a batch
  private lastScratch = 0;
  private readonly controls: Staging;
  private readonly coefficients: Staging;
  private readonly meshList: Staging;
  private readonly regionList: Staging;
  private readonly outputs: Record<ArrayName, Staging>;
  private readonly quantiser: Quantiser;

  /** Takes ownership of the model at an address. */
  constructor(readonly heap: Heap, private address: number) {
    const count = (name: string) => heap.call(name, address);
    this.vertexCount = count("fb_vertex_count");
    this.controlCount = count("fb_control_count");
    this.coefficientCount = count("fb_coefficient_count");
    this.sizes = {
      positions: 3 * this.vertexCount, normals: 3 * this.vertexCount, tangents: 3 * this.vertexCount,
      sockets: 12 * count("fb_socket_count"), joints: 12 * count("fb_driven_joint_count"),
      channels: count("fb_channel_count"), bounds: 6, expectedErrors: 1 + count("fb_error_region_count"), outside: 1,
    };
    this.evaluateCall = heap.exports["fb_evaluate"]!;
    this.evaluateBatchCall = heap.exports["fb_evaluate_batch"]!;
    this.fillDescCall = heap.exports["fb_batch_desc_fill"]!;
    this.descSize = heap.size("fb_batch_desc");
    try {
      this.rooms = PoseRooms.enter(heap);
    } catch (error) {
      heap.call("fb_release", address);
      throw error;
    }
    const staging = (name: string) => new Staging(heap, this.rooms.room(name));
    this.controls = staging("controls");
    this.coefficients = staging("coefficients");
    this.meshList = staging("meshes");
    this.regionList = staging("regions");
    this.outputs = Object.fromEntries(names.map((name) => [name, staging(name)])) as Record<ArrayName, Staging>;
    this.quantiser = new Quantiser(heap, address, this.controlCount, staging);
    try {
      this.scratch = this.lastScratch = this.createScratch("fb_scratch_create_single");
      this.controls.reserve(this.controlCount);
      this.outputs.positions.reserve(this.sizes.positions);
    } catch (error) {
      this.dispose();
      throw error;
    }
  }

  /** The model's address, while it is loaded. */
  get pointer(): number {
    if (this.address === 0) throw invalidArgument("the face is disposed of");
    return this.address;
  }

  private createScratch(create: string): number {
    this.heap.check(create, this.address, 1, this.rooms.desc);
    return this.heap.u32[this.rooms.desc >>> 2]!;
  }

  // Batches take less time with a scratch of their own, in four times the memory.
  private scratchFor(poses: number): number {
    if (poses > 1) this.batchScratch ||= this.createScratch("fb_scratch_create");
    return (this.lastScratch = poses > 1 ? this.batchScratch : this.scratch);
  }

  private putControls(controls: Float32Array, count: number): void {
    if (!(controls instanceof Float32Array) || controls.length < count * this.controlCount)
      throw invalidArgument(`controls: ${controls?.length} numbers, but ${count * this.controlCount} are needed`);
    const to = this.controls.floats(count * this.controlCount);
    to.set(controls.length === to.length ? controls : controls.subarray(0, to.length));
  }

  /** Poses; the result is a view of the module's memory, which holds until the next call. */
  evaluateInPlace(controls: Float32Array): Float32Array {
    const model = this.pointer;
    this.putControls(controls, 1);
    // Called without Heap.check, which would make an array of the arguments.
    const status = this.evaluateCall(model, this.scratchFor(1), this.controls.address, this.outputs.positions.address);
    if (status !== 0) this.heap.fail(status);
    return this.outputs.positions.floats(this.sizes.positions);
  }

  evaluateCoefficients(controls: Float32Array, coefficients: Float32Array): void {
    const model = this.pointer;
    if (coefficients.length < this.coefficientCount)
      throw invalidArgument(`coefficients: ${coefficients.length} numbers, but ${this.coefficientCount} are needed`);
    this.coefficients.reserve(Math.max(this.coefficientCount, 1));
    this.putControls(controls, 1);
    this.heap.check("fb_evaluate_coefficients", model, this.scratchFor(1), this.controls.address, this.coefficients.address);
    coefficients.set(this.coefficients.floats(this.coefficientCount));
  }

  /** Blends two poses, or one and its mirror, in the space of controls. */
  blend(from: Float32Array, to: Float32Array | null, share: number, blended: Float32Array): Float32Array {
    const { heap, controlCount } = this;
    for (const pose of to ? [from, to, blended] : [from, blended])
      if (!(pose instanceof Float32Array) || pose.length < controlCount)
        throw invalidArgument(`a pose of ${pose?.length} numbers, but ${controlCount} are needed`);
    const poses = this.controls; // one behind the other, and the result in place of the first
    poses.reserve(2 * controlCount);
    const values = poses.floats(2 * controlCount);
    values.set(from.subarray(0, controlCount));
    if (to) values.set(to.subarray(0, controlCount), controlCount);
    heap.check("fb_blend_controls", this.pointer, poses.address, to ? poses.address + 4 * controlCount : 0, share,
               poses.address);
    blended.set(poses.floats(2 * controlCount).subarray(0, controlCount));
    return blended;
  }

  /** Quantises `count` poses. */
  quantise(controls: Float32Array, count: number, outputs: QuantisedOutputs): void {
    this.quantiser.quantise(this.pointer, this.scratchFor(count), controls, count, outputs);
  }

  expectedError(controls: Float32Array, errors: Float32Array): number {
    const model = this.pointer, staging = this.outputs.expectedErrors, outside = this.outputs.outside;
    if (errors.length < this.sizes.expectedErrors)
      throw invalidArgument(`errors: ${errors.length} numbers, but ${this.sizes.expectedErrors} are needed`);
    staging.reserve(this.sizes.expectedErrors);
    outside.reserve(1);
    this.putControls(controls, 1);
    this.heap.check("fb_expected_error", model, this.scratchFor(1), this.controls.address, staging.address,
                    outside.address);
    errors.set(staging.floats(this.sizes.expectedErrors));
    return outside.numbers(1)[0]!;
  }

  /** Poses `count` controls and writes every array of the outputs. */
  evaluateBatch(controls: Float32Array, count: number, outputs: Outputs): void {
    const sizes = outputs.levelOnly ? this.levelSizes(outputs.lod ?? 0) : this.sizes;
    let bytes = 0;
    for (const name of names) {
      const array = outputs[name];
      if (!array) continue;
      bytes += 4 * sizes[name];
      if (array.length < count * sizes[name])
        throw invalidArgument(`${name}: ${array.length} numbers, but ${count * sizes[name]} are needed`);
    }
    const atOnce = Math.max(1, Math.floor(bytesAtOnce / Math.max(bytes, 1)));
    for (let first = 0; first < count; first += atOnce)
      this.evaluateSome(controls, first, Math.min(atOnce, count - first), outputs, sizes);
  }

  // Vertices of a level alone.
  private levelSizes(lod: number): Record<ArrayName, number> {
    const { heap } = this, model = this.pointer;
    this.sizesOfLevels ??= Array.from({ length: heap.call("fb_level_count", model) }, (_, index) => {
      const level = heap.fill("fb_level", (to) => heap.check("fb_level_at", model, index, to));
      const numbers = 3 * level.vertex_count;
      return { ...this.sizes, positions: numbers, normals: numbers, tangents: numbers };
    });
    const index = Math.min(Math.floor(lod), this.sizesOfLevels.length - 1);
    return this.sizesOfLevels[index] ?? this.sizes; // that of no level is refused
  }

  private evaluateSome(controls: Float32Array, first: number, count: number, outputs: Outputs,
                       sizes: Record<ArrayName, number>): void {
    const { heap } = this, { desc } = this.rooms, struct = "fb_batch_desc", model = this.pointer;
    const n = this.controlCount, scratch = this.scratchFor(count);
    this.controls.reserve(count * n);
    for (const name of names) if (outputs[name]) this.outputs[name].reserve(count * sizes[name]);
    this.fillDescCall(desc, this.descSize);
    heap.refresh();
    this.putControls(first === 0 ? controls : controls.subarray(first * n), count);
    heap.setU32(struct, desc, "poses", count);
    heap.setU32(struct, desc, "controls", this.controls.address);
    heap.setU32(struct, desc, "control_floats", count * n);
    heap.setU32(struct, desc, "vertex_order", outputs.vertexOrder === "baked" ? 1 : 0);
    heap.setU32(struct, desc, "displacements", outputs.displacements ? 1 : 0);
    heap.setU32(struct, desc, "unskinned", outputs.unskinned ? 1 : 0);
    heap.setF32(struct, desc, "lod", outputs.lod ?? 0);
    heap.setU32(struct, desc, "level_only", outputs.levelOnly ? 1 : 0);
    if (outputs.meshes) this.setList(this.meshList, outputs.meshes, "meshes", "mesh_count");
    if (outputs.regions) this.setList(this.regionList, outputs.regions, "regions", "region_count");
    for (const name of names) {
      const array = outputs[name];
      if (!array) continue;
      const member = members[name], length = count * sizes[name];
      heap.setU32(struct, desc, member.pointer, this.outputs[name].address);
      if (member.size) heap.setU32(struct, desc, member.size, length);
      if (member.stride) heap.setU32(struct, desc, member.stride, sizes[name]);
      if (outputs.meshes) this.view(name, length).set(array.subarray(first * sizes[name], first * sizes[name] + length));
    }
    const status = this.evaluateBatchCall(model, scratch, desc);
    if (status !== 0) heap.fail(status);
    for (const name of names) outputs[name]?.set(this.view(name, count * sizes[name]), first * sizes[name]);
  }

  private setList(staging: Staging, indices: readonly number[], pointer: string, size: string): void {
    const { heap } = this, { desc } = this.rooms;
    staging.reserve(Math.max(indices.length, 1));
    heap.u32.set(indices, staging.address >>> 2);
    heap.setU32("fb_batch_desc", desc, pointer, staging.address);
    heap.setU32("fb_batch_desc", desc, size, indices.length);
  }

  private view(name: ArrayName, length: number): Float32Array | Uint32Array {
    return name === "outside" ? this.outputs[name].numbers(length) : this.outputs[name].floats(length);
  }

  get clampedCount(): number {
    return Number(this.heap.exports["fb_clamped_count"]!(this.lastScratch));
  }

  /** Frees everything. May be called again. */
  dispose(): void {
    const { heap } = this;
    if (this.address === 0) return;
    this.rooms.leave();
    for (const scratch of [this.scratch, this.batchScratch]) if (scratch) heap.call("fb_scratch_destroy", scratch);
    heap.call("fb_release", this.address);
    this.scratch = this.batchScratch = this.lastScratch = this.address = 0;
  }
}

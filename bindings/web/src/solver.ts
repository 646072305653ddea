/** From a face back to its controls: a module of its own, for pages that solve. facebaker_solve.h is the manual. */
import { invalidArgument } from "./errors.js";
import type { LoadOptions } from "./face.js";
import { fetchBytes, type Source } from "./fetch_bytes.js";
import { heapOf, type Heap } from "./heap.js";
import { hasSimd, instanceOf } from "./instance.js";
import { loadArchive, needMemory } from "./load_archive.js";
import { StructArrays } from "./solver_arrays.js";
import { solverUrl } from "./solver_urls.js";

export { FaceBakerError } from "./errors.js";
export type { LoadOptions } from "./face.js";

/** What a solver follows; by default every vertex, as a point. */
export interface Followed {
  /** A vertex a point; with `weights`, three vertices a point. */
  vertices?: ArrayLike<number>;
  /** Three a point: it is the sum of weight x vertex. */
  weights?: ArrayLike<number>;
  /** Two points each, whose distance may have a target. */
  pairs?: ArrayLike<number>;
  /** Sockets, and driven joints, whose frames are followed. */
  sockets?: ArrayLike<number>;
  joints?: ArrayLike<number>;
  /** Level of detail, 0 by default. */
  lod?: number;
}

/** What a pose should come to, and what it should be like beside. Of a target with a NaN nothing is asked. */
export interface SolveTargets {
  /** Three numbers a point. */
  points?: Float32Array;
  /** One a point; 1 by default. */
  pointWeights?: Float32Array;
  /** One a pair, in `units`. */
  distances?: Float32Array;
  distanceWeights?: Float32Array;
  /** Twelve a frame, of sockets and then of joints: three rows of four. */
  frames?: Float32Array;
  frameWeights?: Float32Array;
  /** Points are told as how far they should be from where they are at rest. */
  relative?: boolean;
  /** Where the head is: twelve numbers, three rows of four, in and out. All 0: found from the targets alone. */
  motion?: Float32Array;
  /** Takes targets to the space of the face: twelve numbers, three rows of four. */
  toFace?: Float32Array;
  /** What a point's target is off by itself, in `units`; half a millimetre by default. */
  noise?: number;
  /** What it costs to be away from `near`; 0.1 by default. */
  nearness?: number;
  /** Few controls rather than many; 0.1 by default. */
  sparsity?: number;
  /** What it costs to be away from `before`; 0 by default. */
  smoothness?: number;
  /** What it costs that left and right differ; 0 by default. */
  symmetry?: number;
  /** It ends where an iteration lowers the sum by less than this share; 0.001 by default. */
  tolerance?: number;
  /** How often derivatives are found, at most; 20 by default. */
  maxIterations?: number;
  /** Controls; rest by default. */
  near?: Float32Array;
  /** Controls of the frame before. */
  before?: Float32Array;
  /** One a control, 0: it stays where it starts. */
  movable?: Uint8Array;
  /** Written, one a control: the share of what decides it that comes from the targets. */
  decided?: Float32Array;
  /** Written, one a point: how far it is from its target, in `units`; NaN without one. */
  pointDifferences?: Float32Array;
}

/** How a solution came out; distances in `units`. */
export interface Solution {
  iterations: number;
  /** Not: it ended because of `maxIterations`. */
  converged: boolean;
  /** Points with targets. */
  pointCount: number;
  worstPoint: number;
  rmsDifference: number;
  maxDifference: number;
  /** What was minimised. */
  objective: number;
}

export interface DerivativeOptions {
  /** Indices of controls, ascending; all by default. */
  chosen?: ArrayLike<number>;
  /** One a control, 1: where the pose bends, the derivative is that of moving it down. */
  downwards?: Uint8Array;
}

/** Derivatives that are not 0: those of the chosen control c are the entries from starts[c] to starts[c + 1]. */
export interface SparseDerivatives {
  starts: Uint32Array;
  rows: Uint32Array;
  values: Float32Array;
}

const forgotten = new FinalizationRegistry<SolverMemory>((memory) => memory.release());

// What a solver has in the module's memory.
class SolverMemory {
  solver = 0;
  readonly followed: StructArrays;
  readonly derivatives: StructArrays;
  readonly targets: StructArrays;
  readonly result: StructArrays;

  constructor(readonly heap: Heap, public model: number) {
    this.followed = new StructArrays(heap, "fb_solver_desc");
    this.derivatives = new StructArrays(heap, "fb_jacobian_desc");
    this.targets = new StructArrays(heap, "fb_solve_desc");
    this.result = new StructArrays(heap, "fb_solve_result");
  }

  release(): void {
    for (const arrays of [this.followed, this.derivatives, this.targets, this.result]) arrays.release();
    if (this.solver) this.heap.call("fb_solver_destroy", this.solver);
    if (this.model) this.heap.call("fb_release", this.model);
    this.solver = this.model = 0;
  }
}

/** A face that can be solved for. Calls do not overlap; a worker of yours may have it. Not to be used after `dispose`. */
export class Solver {
  readonly controlCount: number;
  /** What is followed: points, pairs, and frames of sockets and joints. */
  pointCount = 0;
  pairCount = 0;
  frameCount = 0;
  /** Numbers that are followed: 3 a point, then 12 a frame. */
  rowCount = 0;

  /** For `loadSolver`. */
  constructor(private readonly memory: SolverMemory) {
    this.controlCount = memory.heap.call("fb_control_count", memory.model);
    forgotten.register(this, memory, this);
  }

  /** The index of a control by its name, or else by its ARKit or FACS name. */
  findControl(name: string): number {
    const { heap } = this.memory, result = heap.allocate(4);
    try {
      heap.withText(name, (text) => heap.check("fb_find_control", this.memory.model, text, result));
      return heap.u32[result >>> 2]!;
    } finally {
      heap.release(result);
    }
  }

  /** The controls of the rest pose, to be changed. */
  createPose(): Float32Array {
    const { heap, model } = this.memory;
    return heap.copyF32(heap.call("fb_rest_controls", model), this.controlCount);
  }

  /** Follows other points and frames from now on. Takes some milliseconds, for all vertices of a large face a tenth of
   * a second. */
  follow(followed: Followed = {}): void {
    const { heap, model, followed: desc } = this.memory;
    if (model === 0) throw invalidArgument("the solver is disposed of");
    const { vertices, weights, pairs, sockets, joints } = followed;
    const address = desc.begin(), result = heap.allocate(4);
    const list = (member: string, numbers: ArrayLike<number> | undefined, size: string) => {
      if (numbers) desc.put(member, Uint32Array.from(numbers), numbers.length);
      desc.setU32(size, numbers?.length ?? 0);
    };
    try {
      if (vertices) {
        const points = weights ? Uint32Array.from(vertices) : Uint32Array.from(vertices).reduce(
          (all, vertex, i) => (all[3 * i] = vertex, all), new Uint32Array(3 * vertices.length));
        desc.put("point_vertices", points, points.length);
        desc.setU32("point_count", Math.floor(points.length / 3));
        if (weights) desc.put("point_weights", Float32Array.from(weights), points.length);
      }
      if (pairs) desc.put("pairs", Uint32Array.from(pairs), pairs.length);
      desc.setU32("pair_count", Math.floor((pairs?.length ?? 0) / 2));
      list("sockets", sockets, "socket_count");
      list("joints", joints, "joint_count");
      desc.setF32("lod", followed.lod);
      needMemory(() => heap.check("fb_solver_create", model, address, result));
      if (this.memory.solver) heap.call("fb_solver_destroy", this.memory.solver);
      this.memory.solver = heap.u32[result >>> 2]!;
    } finally {
      heap.release(result);
    }
    this.pointCount = heap.call("fb_solver_point_count", this.memory.solver);
    this.rowCount = heap.call("fb_solver_row_count", this.memory.solver);
    this.pairCount = Math.floor((pairs?.length ?? 0) / 2);
    this.frameCount = (sockets?.length ?? 0) + (joints?.length ?? 0);
  }

  // Every vertex is followed where nothing else was asked for.
  private ready(): number {
    if (this.memory.solver === 0) this.follow();
    return this.memory.solver;
  }

  /** The values that are followed, row after row, in a pose. */
  values(controls: Float32Array): Float32Array {
    this.ready();
    const values = new Float32Array(this.rowCount);
    this.derive(controls, {}, (desc) => desc.put("values", values, values.length));
    this.memory.derivatives.get("values", values, values.length);
    return values;
  }

  /** Derivatives of the values that are followed by the controls: row after row, a number for each chosen control. */
  jacobian(controls: Float32Array, options: DerivativeOptions = {}): Float32Array {
    const columns = options.chosen?.length ?? this.controlCount;
    this.ready();
    const dense = new Float32Array(this.rowCount * columns);
    this.derive(controls, options, (desc) => {
      desc.put("derivatives", dense, dense.length);
      desc.setU32("derivative_floats", dense.length);
    });
    this.memory.derivatives.get("derivatives", dense, dense.length);
    return dense;
  }

  /** The same without what is 0. */
  sparseJacobian(controls: Float32Array, options: DerivativeOptions = {}): SparseDerivatives {
    const { derivatives: desc } = this.memory;
    const words = new Uint32Array(2 * ((options.chosen?.length ?? this.controlCount) + 1)); // of 64 bits each
    this.derive(controls, options, () => desc.put("column_starts", words, words.length));
    desc.get("column_starts", words, words.length);
    const starts = words.filter((_, i) => i % 2 === 0), count = starts.at(-1)!;
    const rows = new Uint32Array(count), values = new Float32Array(count);
    this.derive(controls, options, () => {
      desc.put("column_starts", words, words.length);
      desc.put("column_rows", rows, count);
      desc.put("column_values", values, count);
      desc.setU32("column_entries", count);
    });
    desc.get("column_rows", rows, count);
    desc.get("column_values", values, count);
    return { starts, rows, values };
  }

  private derive(controls: Float32Array, options: DerivativeOptions, outputs: (desc: StructArrays) => void): void {
    const solver = this.ready(), { heap, derivatives: desc } = this.memory, { chosen } = options, address = desc.begin();
    desc.put("controls", controls, this.controlCount);
    if (chosen) {
      desc.put("chosen", Uint32Array.from(chosen), chosen.length);
      desc.setU32("chosen_count", chosen.length);
    }
    desc.put("downwards", options.downwards, this.controlCount);
    outputs(desc);
    heap.check("fb_jacobian", solver, address);
  }

  /** Finds controls for targets. `controls`: in, where it starts; out, what was found, within the ranges. */
  solve(controls: Float32Array, targets: SolveTargets): Solution {
    const solver = this.ready(), { heap, targets: desc, result } = this.memory;
    const address = desc.begin(), to = result.begin();
    desc.put("controls", controls, this.controlCount);
    this.putTargets(targets);
    if (targets.maxIterations !== undefined) desc.setU32("max_iterations", targets.maxIterations);
    for (const name of ["noise", "nearness", "sparsity", "smoothness", "symmetry", "tolerance"] as const)
      desc.setF32(name, targets[name]);
    if (targets.toFace) heap.f32.set(targets.toFace.subarray(0, 12), (address + heap.offset("fb_solve_desc", "to_face")) >>> 2);
    heap.check("fb_solve", solver, address, to);
    desc.get("controls", controls, this.controlCount);
    desc.get("motion", targets.motion, 12);
    desc.get("decided", targets.decided, this.controlCount);
    desc.get("point_differences", targets.pointDifferences, this.pointCount);
    const found = heap.read("fb_solve_result", to);
    return { iterations: found["iterations"], converged: found["converged"] === 1, pointCount: found["point_count"],
             worstPoint: found["worst_point"], rmsDifference: found["rms_difference"],
             maxDifference: found["max_difference"], objective: found["objective"] };
  }

  private putTargets(targets: SolveTargets): void {
    const { targets: desc } = this.memory, { pointCount, pairCount, frameCount, controlCount } = this;
    desc.put("points", targets.points, 3 * pointCount);
    desc.put("point_weights", targets.pointWeights, pointCount);
    desc.put("distances", targets.distances, pairCount);
    desc.put("distance_weights", targets.distanceWeights, pairCount);
    desc.put("frames", targets.frames, 12 * frameCount);
    desc.put("frame_weights", targets.frameWeights, frameCount);
    desc.setU32("relative", targets.relative ? 1 : 0);
    desc.setU32("find_motion", targets.motion ? 1 : 0);
    desc.put("motion", targets.motion, 12);
    desc.put("near_controls", targets.near, controlCount);
    desc.put("before", targets.before, controlCount);
    desc.put("movable", targets.movable, controlCount);
    desc.put("decided", targets.decided, controlCount);
    desc.put("point_differences", targets.pointDifferences, pointCount);
  }

  /** Frees the solver and its face. */
  dispose(): void {
    forgotten.unregister(this);
    this.memory.release();
  }
}

/** Loads a face to solve for, from a URL or from its bytes, as `load` of "facebaker" does. The face is apart from those
 * of `load`, in the memory of a module of its own. */
export async function loadSolver(source: Source, options: LoadOptions = {}): Promise<Solver> {
  const fetching = fetchBytes(source, options);
  fetching.catch(() => undefined); // reported below
  const exports = await instanceOf(options.wasm ?? solverUrl(options.simd ?? hasSimd()));
  const bytes = await fetching;
  options.signal?.throwIfAborted();
  const heap = heapOf(exports);
  return needMemory(() => new Solver(new SolverMemory(heap, loadArchive(heap, bytes, options.limits))));
}

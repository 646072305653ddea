import { ContentsReader } from "./read_contents.js";
import type { FaceContents } from "./contents.js";
import { Model, type Outputs } from "./model.js";
import { fetchBytes, type FetchOptions, type Source } from "./fetch_bytes.js";
import { instanceOf, type WasmSource } from "./instance.js";
import { heapOf } from "./heap.js";
import { loadArchive, needMemory, type LoadLimits } from "./load_archive.js";
import type { QuantisedOutputs } from "./quantised_poses.js";
import { readExactCorrections, readRowBlocks, type RowBlock } from "./row_blocks.js";
import { FaceBakerError, invalidArgument } from "./errors.js";

export interface LoadOptions extends FetchOptions {
  /** Where the WebAssembly module is, or its bytes; beside this script by default. */
  wasm?: WasmSource | undefined;
  /** Called as the archive arrives. `total` is 0 < loaded <= total; it equals `loaded` where the length is unknown. */
  progress?: ((loaded: number, total: number) => void) | undefined;
  signal?: AbortSignal | undefined;
  /** Whether to use WebAssembly SIMD; by default where there is one. Results are the same. */
  simd?: boolean | undefined;
  limits?: LoadLimits | undefined;
}

/** What to expect of a pose, see Face.expectedError. */
export interface ExpectedError {
  /** Root mean square distance from the rig over the whole face, in `units`. */
  face: number;
  /** The same of each region, in the order of `regions.names`. */
  regions: Float32Array;
  /** How many controls are outside of what was trained. */
  outside: number;
}

/** A pose of one of the characters that share a face, see Face.evaluateMany. */
export interface CharacterPose<Wanted extends Outputs = Outputs> {
  controls: Float32Array;
  outputs: Wanted;
}

const forgotten = new FinalizationRegistry<Model>((model) => model.dispose());

/** A loaded face. Contents are read from the module's memory when they are first asked for, and kept. Not to be used
 * after `dispose`. */
export class Face implements FaceContents {
  private readonly kept = new Map<string, unknown>();

  /** For `load`. */
  constructor(private readonly model: Model) {
    forgotten.register(this, model, this);
  }

  // Reads a part once.
  private part<Part>(name: string, read: (reader: ContentsReader) => Part): Part {
    if (!this.kept.has(name)) this.kept.set(name, read(new ContentsReader(this.model.heap, this.model.pointer)));
    return this.kept.get(name) as Part;
  }

  get name() { return this.part("name", (r) => r.text("fb_name")); }
  get units() { return this.part("units", (r) => r.text("fb_units")); }
  get upAxis() { return this.part("upAxis", (r) => r.text("fb_up_axis") as "y" | "z"); }
  get diagonal() { return this.part("diagonal", (r) => r.number("fb_diagonal")); }
  get vertexCount() { return this.model.vertexCount; }
  get controlCount() { return this.model.controlCount; }
  get coefficientCount() { return this.model.coefficientCount; }
  get controls() { return this.part("controls", (r) => r.controls()); }
  get meshes() { return this.part("meshes", (r) => r.meshes()); }
  get uvs() { return this.part("uvs", (r) => r.uvs()); }
  get tangentSigns() { return this.part("tangentSigns", (r) => r.tangentSigns()); }
  get materials() { return this.part("materials", (r) => r.materials()); }
  get images() { return this.part("images", (r) => r.images()); }
  get sockets() { return this.part("sockets", (r) => r.sockets()); }
  get channels() { return this.part("channels", (r) => r.channels()); }
  get exactPoses() { return this.part("exactPoses", (r) => r.exactPoses()); }
  get joints() { return this.part("joints", (r) => r.joints()); }
  get skin() { return this.part("skin", (r) => r.skin()); }
  get drivenJoints() { return this.part("drivenJoints", (r) => r.drivenJoints()); }
  get drivenSkin() { return this.part("drivenSkin", (r) => r.drivenSkin()); }
  get levels() { return this.part("levels", (r) => r.levels()); }
  get regions() { return this.part("regions", (r) => r.regions()); }
  get networkRegions() { return this.part("networkRegions", (r) => r.networkRegions()); }
  get vertexOrder() { return this.part("vertexOrder", (r) => r.vertexOrder()); }
  get provenance() { return this.part("provenance", (r) => r.text("fb_provenance")); }
  get about() { return this.part("about", (r) => r.text("fb_about")); }
  get thumbnail() { return this.part("thumbnail", (r) => r.thumbnail()); }
  get instructionSet() { return this.part("instructionSet", (r) => r.text("fb_instruction_set")); }
  get runtimeBytes() { return this.part("runtimeBytes", (r) => r.number("fb_runtime_bytes")); }
  get restControls() { return this.part("restControls", (r) => r.floats("fb_rest_controls", this.controlCount)); }
  get restPositions() {
    return this.part("restPositions", (r) => r.floats("fb_rest_positions", 3 * this.vertexCount));
  }
  /** The basis, for a GPU: as it is stored, about a byte a number. */
  get rowBlocks(): readonly RowBlock[] {
    return this.part("rowBlocks", () => readRowBlocks(this.model.heap, this.model.pointer));
  }

  /** By exact pose and row block: what its rows are corrected by at a weight of 1; null where it leaves them alone. */
  get exactCorrections(): readonly (readonly (Float32Array | null)[])[] {
    const rows = () => this.rowBlocks.map(({ rowCount }) => rowCount);
    return this.part("exactCorrections", () => readExactCorrections(this.model.heap, this.model.pointer, rows()));
  }

  /** All of the contents, as a plain object that can be sent to another thread. */
  contents(): FaceContents {
    const { name, units, upAxis, diagonal, vertexCount, controlCount, coefficientCount, controls, meshes, uvs,
            tangentSigns, materials, images, sockets, channels, exactPoses, joints, skin, drivenJoints, drivenSkin,
            levels, regions, networkRegions, vertexOrder, provenance, about, thumbnail, instructionSet, runtimeBytes,
            restControls, restPositions } = this;
    return { name, units, upAxis, diagonal, vertexCount, controlCount, coefficientCount, controls, meshes, uvs,
             tangentSigns, materials, images, sockets, channels, exactPoses, joints, skin, drivenJoints, drivenSkin,
             levels, regions, networkRegions, vertexOrder, provenance, about, thumbnail, instructionSet, runtimeBytes,
             restControls, restPositions };
  }

  /** The index of a control by its name, or else by its ARKit or FACS name, or by the hash of its name, as
   * `facebaker header` writes it. Throws a FaceBakerError, for a name with the closest one. */
  findControl(name: string | bigint): number {
    const { heap, pointer } = this.model, result = heap.allocate(4);
    try {
      if (typeof name === "bigint") heap.check("fb_find_control_hash", pointer, name, result);
      else heap.withText(name, (text) => heap.check("fb_find_control", pointer, text, result));
      return heap.u32[result >>> 2]!;
    } finally {
      heap.release(result);
    }
  }

  /** Blends two poses as controls, `from` at share 0 and `to` at 1, clamped to their ranges; a `to` of null is the mirror
   * of `from`. `blended` may be either; without it, an array is made. Throws on NaN, naming the control. */
  blend(from: Float32Array, to: Float32Array | null, share: number, blended?: Float32Array): Float32Array {
    return this.model.blend(from, to, share, blended ?? new Float32Array(this.controlCount));
  }

  /** The controls of the rest pose, to be changed. */
  createPose(): Float32Array {
    return this.restControls.slice();
  }

  /** Poses the face: 3 numbers a vertex, in the order of the source. Values outside of a control's range are clamped.
   * With `positions`, of at least 3 * vertexCount numbers, nothing is allocated. Throws on NaN, naming the control. */
  evaluate(controls: Float32Array, positions?: Float32Array): Float32Array {
    const posed = this.model.evaluateInPlace(controls);
    if (!positions) return posed.slice();
    if (positions.length < posed.length)
      throw invalidArgument(`positions: ${positions.length} numbers, but ${posed.length} are needed`);
    positions.set(posed);
    return positions;
  }

  /** The same without copying: a view of the module's memory, which holds until the next call of any face. */
  evaluateInPlace(controls: Float32Array): Float32Array {
    return this.model.evaluateInPlace(controls);
  }

  /** Poses the face and writes all arrays that `outputs` has: normals, tangents, sockets, joints, ... */
  evaluateInto<Wanted extends Outputs>(controls: Float32Array, outputs: Wanted): Wanted {
    this.model.evaluateBatch(controls, 1, outputs);
    return outputs;
  }

  /** Poses the face `count` times; controls and outputs of the poses follow each other. */
  evaluateBatch<Wanted extends Outputs>(controls: Float32Array, count: number, outputs: Wanted): Wanted {
    this.model.evaluateBatch(controls, count, outputs);
    return outputs;
  }

  /** Poses characters that share this face, each with outputs and a level of detail of its own. A character takes no
   * memory but these arrays. Throws at the first pose that fails, with a message that begins with "character I: ". */
  evaluateMany<Wanted extends Outputs>(poses: readonly CharacterPose<Wanted>[]): void {
    poses.forEach(({ controls, outputs }, index) => {
      try {
        this.model.evaluateBatch(controls, 1, outputs);
      } catch (error) {
        if (error instanceof FaceBakerError)
          throw new FaceBakerError(error.status, error.statusName, `character ${index}: ${error.message}`);
        throw error;
      }
    });
  }

  /** The coefficients of a pose, all 0 at rest: what a GPU multiplies `rowBlocks` with. Of a face with driven joints
   * that gives positions before these move them. Where they are, `evaluateInto(controls, { joints, meshes: [] })` gives
   * without evaluating vertices. */
  coefficients(controls: Float32Array,
               coefficients: Float32Array = new Float32Array(this.coefficientCount)): Float32Array {
    this.model.evaluateCoefficients(controls, coefficients);
    return coefficients;
  }

  /** The quantised coefficients of `count` poses, for a GPU that is to give the very bits of `evaluate`: see "Poses for a
   * GPU" in facebaker.h, and `GpuEvaluator` of "facebaker/webgpu", which does so. */
  quantise<Wanted extends QuantisedOutputs>(controls: Float32Array, count: number, outputs: Wanted): Wanted {
    this.model.quantise(controls, count, outputs);
    return outputs;
  }

  /** How far vertices are expected to be from where the rig has them. Throws if the face has no expected errors. */
  expectedError(controls: Float32Array): ExpectedError {
    const errors = new Float32Array(1 + this.regions.names.length);
    const outside = this.model.expectedError(controls, errors);
    return { face: errors[0]!, regions: errors.subarray(1), outside };
  }

  /** Control values that the last evaluation clamped. */
  get clampedCount(): number {
    return this.model.clampedCount;
  }

  /** Frees the face's memory. A face that is forgotten is freed too, but later, when the browser gets to it. */
  dispose(): void {
    forgotten.unregister(this);
    this.model.dispose();
    this.kept.clear();
  }
}

/** `load` of load.ts, with a module that is known. */
export async function loadWith(wasm: WasmSource, source: Source, options: LoadOptions): Promise<Face> {
  const fetching = fetchBytes(source, options);
  fetching.catch(() => undefined); // reported below
  const exports = await instanceOf(wasm);
  const bytes = await fetching;
  options.signal?.throwIfAborted();
  const heap = heapOf(exports);
  return needMemory(() => new Face(new Model(heap, loadArchive(heap, bytes, options.limits))));
}

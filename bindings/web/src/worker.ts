/** The same as "facebaker", in a worker: a page stays free while faces are loaded and posed. */
import { startWorker, wasmUrl, workerUrl } from "./asset_urls.js";
import { closestName } from "./closest_name.js";
import type { FaceContents } from "./contents.js";
import { FaceBakerError } from "./errors.js";
import type { CharacterPose, ExpectedError, LoadOptions } from "./face.js";
import type { Source } from "./fetch_bytes.js";
import { hasSimd } from "./instance.js";
import type { Outputs } from "./model.js";
import { isNode, nodeModule } from "./platform.js";
import type { RowBlock } from "./row_blocks.js";
import { outputBuffers, type Answer, type Message, type Request, type Results } from "./worker_messages.js";

export { FaceBakerError } from "./errors.js";
export type { CharacterPose, LoadOptions, ExpectedError } from "./face.js";
export type { Outputs } from "./model.js";
export * from "./contents.js";

// A browser's worker or one of Node's.
interface Thread {
  post(message: Message, transfer: readonly ArrayBuffer[]): void;
  stop(): void;
}

async function startThread(script: URL | string | undefined, receive: (answer: Answer) => void,
                           fail: (message: string) => void): Promise<Thread> {
  if (isNode) {
    const { Worker } = await nodeModule("worker_threads");
    const worker = new Worker(script === undefined ? workerUrl() : script);
    worker.on("message", (answer) => receive(answer as Answer));
    worker.on("error", (error) => fail(String(error)));
    return { post: (message, transfer) => worker.postMessage(message, transfer), stop: () => void worker.terminate() };
  }
  const worker = script === undefined ? startWorker() : new Worker(script);
  worker.onmessage = (event) => receive(event.data as Answer);
  worker.onerror = (event) => fail(event.message || "the worker's script cannot be loaded");
  return { post: (message, transfer) => worker.postMessage(message, transfer as Transferable[]),
           stop: () => worker.terminate() };
}

const interrupted = (message: string) => new FaceBakerError(12, "FB_ERROR_INTERRUPTED", message);

interface Waiting {
  resolve(result: unknown): void;
  reject(error: Error): void;
  progress: ((loaded: number, total: number) => void) | undefined;
}

// Sends requests and matches answers to them.
class Calls {
  private readonly waiting = new Map<number, Waiting>();
  private thread!: Thread;
  private last = 0;
  private stopped = "";

  static async start(script: URL | string | undefined): Promise<Calls> {
    const calls = new Calls();
    calls.thread = await startThread(script, (answer) => calls.receive(answer), (message) => calls.stop(message));
    return calls;
  }

  call<Name extends Request["call"]>(request: Request & { call: Name }, transfer: readonly ArrayBuffer[] = [],
                                     progress?: (loaded: number, total: number) => void): Promise<Results[Name]> {
    return new Promise((resolve, reject) => {
      if (this.stopped) throw interrupted(this.stopped);
      const id = ++this.last;
      this.waiting.set(id, { resolve: resolve as (result: unknown) => void, reject, progress });
      try {
        this.thread.post({ id, request }, transfer);
      } catch (error) {
        this.waiting.delete(id);
        reject(error as Error);
      }
    });
  }

  /** Ends the worker; calls that wait are refused. */
  stop(message: string): void {
    this.stopped ||= message;
    this.thread?.stop();
    for (const { reject } of this.waiting.values()) reject(interrupted(message));
    this.waiting.clear();
  }

  private receive(answer: Answer): void {
    const found = this.waiting.get(answer.id);
    if (!found) return;
    if ("loaded" in answer) {
      found.progress?.(answer.loaded, answer.total);
      return;
    }
    this.waiting.delete(answer.id);
    if ("result" in answer) found.resolve(answer.result);
    else {
      const { message, status, statusName } = answer.error;
      found.reject(status === undefined ? new Error(message) : new FaceBakerError(status, statusName ?? "", message));
    }
  }
}

/** A face in a worker. What it has, `contents`, is here; poses are computed there, in the order they are asked for. */
export class WorkerFace {
  private readonly names: Map<string, number>;
  /** For `load`. */
  constructor(private readonly calls: Calls, readonly contents: FaceContents) {
    this.names = new Map();
    for (const label of ["facs", "arkit", "name"] as const)
      for (const control of contents.controls) if (control[label]) this.names.set(control[label], control.index);
  }

  get vertexCount() { return this.contents.vertexCount; }
  get controlCount() { return this.contents.controlCount; }
  get controls() { return this.contents.controls; }
  get meshes() { return this.contents.meshes; }
  get restControls() { return this.contents.restControls; }
  get restPositions() { return this.contents.restPositions; }

  /** As in "facebaker". */
  findControl(name: string): number {
    const found = this.names.get(name);
    if (found !== undefined) return found;
    const closest = closestName(name, this.controls.map((control) => control.name));
    throw new FaceBakerError(2, "FB_ERROR_NOT_FOUND", `there is no control "${name}"; the closest is "${closest}"`);
  }

  createPose(): Float32Array {
    return this.contents.restControls.slice();
  }

  /** The positions of a pose. Where `positions` is given, its buffer goes to the worker and comes back in the result:
   * the array that was given is empty afterwards. Controls are copied. */
  async evaluate(controls: Float32Array, positions?: Float32Array): Promise<Float32Array> {
    const to = positions ?? new Float32Array(3 * this.vertexCount), copy = controls.slice();
    const result = await this.calls.call({ call: "evaluate", controls: copy, positions: to },
                                         [copy.buffer as ArrayBuffer, to.buffer as ArrayBuffer]);
    return result.positions;
  }

  /** As in "facebaker"; the buffers of the outputs go to the worker and come back in the result. */
  async evaluateInto<Wanted extends Outputs>(controls: Float32Array, outputs: Wanted): Promise<Wanted> {
    return this.evaluateBatch(controls, 1, outputs);
  }

  async evaluateBatch<Wanted extends Outputs>(controls: Float32Array, count: number, outputs: Wanted): Promise<Wanted> {
    const copy = controls.slice();
    const result = await this.calls.call({ call: "evaluateBatch", controls: copy, count, outputs },
                                         [copy.buffer as ArrayBuffer, ...outputBuffers(outputs)]);
    return result.outputs as Wanted;
  }

  /** As in "facebaker", by one message to the worker, where a pose each would take two. Outputs, in the order of the
   * poses, have the buffers that were given; controls are copied. */
  async evaluateMany<Wanted extends Outputs>(poses: readonly CharacterPose<Wanted>[]): Promise<Wanted[]> {
    const copies = poses.map(({ controls, outputs }) => ({ controls: controls.slice(), outputs }));
    const buffers = copies.flatMap(({ controls, outputs }) => [controls.buffer as ArrayBuffer, ...outputBuffers(outputs)]);
    return (await this.calls.call({ call: "evaluateMany", poses: copies }, [...new Set(buffers)])) as Wanted[];
  }

  coefficients(controls: Float32Array): Promise<Float32Array> {
    return this.calls.call({ call: "coefficients", controls });
  }

  expectedError(controls: Float32Array): Promise<ExpectedError> {
    return this.calls.call({ call: "expectedError", controls });
  }

  rowBlocks(): Promise<readonly RowBlock[]> {
    return this.calls.call({ call: "rowBlocks" });
  }

  /** Frees the face and ends its worker. */
  async dispose(): Promise<void> {
    await this.calls.call({ call: "dispose" }).catch(() => undefined);
    this.calls.stop("the face is disposed of");
  }
}

export interface WorkerOptions extends LoadOptions {
  /** Where the worker's script is, worker_main.js of the package; beside this script by default. */
  worker?: URL | string | undefined;
}

/** Loads a face in a worker of its own. Bytes that are given as the source are copied. */
export async function load(source: Source, options: WorkerOptions = {}): Promise<WorkerFace> {
  const { limits, progress, signal, worker } = options;
  signal?.throwIfAborted();
  // Addresses are relative to the page, those of Next's URLs too, and URLs cannot be sent.
  const resolve = (address: string) => (isNode ? address : new URL(address, document.baseURI).href);
  const plain = <Kind>(given: Kind | URL | string): Kind | string =>
    given instanceof URL ? resolve(given.href) : typeof given === "string" ? resolve(given) : given;
  const wasm = options.wasm ?? wasmUrl(options.simd ?? hasSimd());
  const calls = await Calls.start(worker);
  const abort = () => calls.stop("loading was aborted");
  signal?.addEventListener("abort", abort);
  try {
    const contents = await calls.call({ call: "load", source: plain(source), wasm: plain(wasm), limits,
                                        progress: progress !== undefined }, [], progress);
    return new WorkerFace(calls, contents);
  } catch (error) {
    calls.stop("loading failed");
    signal?.throwIfAborted();
    throw error;
  } finally {
    signal?.removeEventListener("abort", abort);
  }
}

import type { Clip } from "../clips/clip";
import { tokenHeaders } from "./access_token";

/** What the page is told about where it stands: see `facebaker view`. */
export interface Beside {
  name: string;
  live: boolean;
}

/** Who is told of true positions. */
export interface TruthListener {
  /** Those of the pose shown may be known now. */
  ready(): void;
  /** Those of all frames of the clip that is open are: frames x vertices x 3. */
  clipRead(clip: Clip, points: Float32Array): void;
  failed(reason: string): void;
}

/**
 * Where vertices truly are in the pose shown: the recorded frame of a clip, or what a live rig beside the face answers.
 * Answers come later; the listener is told then.
 */
export class TruePositions {
  /** The server evaluates any pose of a live rig. */
  live = false;
  #clip: Clip | null = null;
  #points: Float32Array | null = null;
  #asked: Float32Array | null = null; // controls of the answer below, or of the one that is under way
  #answer: Float32Array | null = null;
  #busy = false;

  constructor(
    readonly vertexCount: number,
    readonly listener: TruthListener,
  ) {}

  /** A clip is shown now; its positions are read if it has any. */
  open(clip: Clip | null): void {
    this.#clip = clip;
    this.#points = null;
    clip?.reference?.().then(
      (points) => {
        if (this.#clip !== clip) return;
        this.#points = points;
        this.listener.clipRead(clip, points);
        this.listener.ready();
      },
      (error: unknown) => this.listener.failed(error instanceof Error ? error.message : String(error)),
    );
  }

  get known(): boolean {
    return this.live || this.#clip?.reference !== undefined;
  }

  /** The positions for these controls, which are those of `frame` if that is not null; null if they are not there (yet). */
  at(controls: Float32Array, frame: number | null): Float32Array | null {
    const size = 3 * this.vertexCount;
    if (frame !== null && this.#points) return this.#points.subarray(frame * size, (frame + 1) * size);
    if (frame !== null && this.#clip?.reference) return null;
    if (!this.live) return null;
    if (this.#answer && this.#asked && same(controls, this.#asked)) return this.#answer;
    if (!this.#busy) void this.#ask(controls.slice());
    return null;
  }

  async #ask(controls: Float32Array): Promise<void> {
    this.#busy = true;
    try {
      const answer = await fetch("./beside/pose", { method: "POST", headers: tokenHeaders(), body: controls.buffer as ArrayBuffer });
      if (!answer.ok) throw new Error((await answer.text()).trim());
      this.#answer = new Float32Array(await answer.arrayBuffer());
      this.#asked = controls;
      this.listener.ready();
    } catch (error) {
      this.live = false;
      this.listener.failed(error instanceof Error ? error.message : String(error));
    } finally {
      this.#busy = false;
    }
  }
}

const same = (a: Float32Array, b: Float32Array): boolean => a.length === b.length && a.every((value, i) => value === b[i]);

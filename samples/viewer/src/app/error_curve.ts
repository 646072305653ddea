import type { Face } from "facebaker";
import type { Clip } from "../clips/clip";
import { Signal } from "./signal";
import { measureErrors } from "./vertex_errors";

const SLICE = 6; // milliseconds, after which the page has its turn
const MOST_PEAKS = 20;
const APART = 0.25; // seconds between two frames that are both among the worst

/** The largest distance of a vertex from where it should be, of each frame of a clip: measured in slices, so that the page
 * goes on. */
export class ErrorCurve {
  readonly changed = new Signal();
  /** One a frame, in the rig's unit; NaN: not known (yet). */
  largest = new Float32Array(0);
  #measured = 0;
  #measuring = false;
  #gaveUp = false;
  #run = 0; // which clip is measured
  #fps = 30;
  #peaks: number[] | null = null; // null: to be found

  /** Another clip, of which nothing is known yet; null: none. */
  open(clip: Clip | null): void {
    ++this.#run;
    this.#measuring = false;
    this.#measured = 0;
    this.#gaveUp = false;
    this.#peaks = null;
    this.#fps = clip?.fps ?? 30;
    this.largest = new Float32Array(clip?.frames ?? 0).fill(NaN);
    this.changed.emit();
  }

  /** Measures all frames of the clip that is open. `points`: frames x vertices x 3. */
  async measure(face: Face, clip: Clip, points: Float32Array): Promise<void> {
    const run = ++this.#run;
    const size = 3 * face.vertexCount;
    const frames = Math.min(clip.frames, Math.floor(points.length / size));
    const width = clip.controls.length / clip.frames;
    const distances = new Float32Array(face.vertexCount);
    this.#measuring = true;
    for (let frame = 0; frame < frames; ) {
      const start = performance.now();
      while (frame < frames && performance.now() - start < SLICE) {
        const posed = face.evaluateInPlace(clip.controls.subarray(frame * width, (frame + 1) * width));
        this.#put(frame, measureErrors(posed, points.subarray(frame * size, (frame + 1) * size), distances).max);
        ++frame;
      }
      this.#measuring = frame < frames;
      this.changed.emit();
      await new Promise((resolve) => setTimeout(resolve));
      if (run !== this.#run) return;
    }
  }

  /** True positions could not be read. */
  giveUp(): void {
    this.#gaveUp = true;
    this.changed.emit();
  }

  /** A frame was measured because it is shown. */
  note(frame: number, error: number): void {
    if (frame >= this.largest.length || this.largest[frame] === error) return;
    this.#put(frame, error);
    this.changed.emit();
  }

  /** Frames that are measured. */
  get measured(): number {
    return this.#measured;
  }
  get measuring(): boolean {
    return this.#measuring;
  }
  get gaveUp(): boolean {
    return this.#gaveUp;
  }

  /** Frames with the largest errors, the worst first, some apart from each other. */
  get peaks(): readonly number[] {
    return (this.#peaks ??= this.#findPeaks());
  }

  /** The frame with the next smaller peak than that at `frame`; the worst one where there is none at it, or no smaller. */
  nextWorst(frame: number): number | null {
    const { peaks } = this;
    return peaks[(peaks.indexOf(frame) + 1) % peaks.length] ?? null;
  }

  #findPeaks(): number[] {
    const apart = Math.max(1, Math.round(APART * this.#fps));
    const order = Array.from(this.largest.keys()).filter((frame) => this.largest[frame] > 0);
    order.sort((a, b) => this.largest[b] - this.largest[a] || a - b);
    const peaks: number[] = [];
    for (const frame of order) {
      if (peaks.length === MOST_PEAKS) break;
      if (peaks.every((peak) => Math.abs(peak - frame) >= apart)) peaks.push(frame);
    }
    return peaks;
  }

  #put(frame: number, error: number): void {
    if (Number.isNaN(this.largest[frame])) ++this.#measured;
    this.largest[frame] = error;
    this.#peaks = null;
  }
}

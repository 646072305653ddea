import { Signal } from "../app/signal";
import type { Clip } from "./clip";

export const KEYFRAME_RATE = 30; // frames a second
const STEP = KEYFRAME_RATE / 2; // from the last pose to one that is added
export const MOST_FRAMES = 600 * KEYFRAME_RATE;

/** A pose at a frame. */
export interface Keyframe {
  readonly frame: number;
  readonly values: Float32Array;
}

/** Poses over time, by frame, each at another one. */
export class KeyframeList {
  readonly changed = new Signal();
  #all: readonly Keyframe[] = [];

  get all(): readonly Keyframe[] {
    return this.#all;
  }

  /** Adds a pose half a second after the last. */
  add(values: Float32Array): Keyframe {
    const last = this.#all.at(-1);
    const added = { frame: this.#freeFrame(last ? last.frame + STEP : 0), values: values.slice() };
    this.replace([...this.#all, added]);
    return added;
  }

  /** Moves a pose to a frame; to the next free one where another pose is there. */
  move(keyframe: Keyframe, frame: number): void {
    const others = this.#all.filter((other) => other !== keyframe);
    this.#all = others;
    this.replace([...others, { frame: this.#freeFrame(frame), values: keyframe.values }]);
  }

  /** Gives the pose of a frame other values. */
  set(keyframe: Keyframe, values: Float32Array): void {
    this.replace(this.#all.map((other) => (other === keyframe ? { frame: other.frame, values: values.slice() } : other)));
  }

  remove(keyframe: Keyframe): void {
    this.replace(this.#all.filter((other) => other !== keyframe));
  }

  /** Others in place of all, in any order, each at another frame. */
  replace(all: readonly Keyframe[]): void {
    this.#all = [...all].sort((a, b) => a.frame - b.frame);
    this.changed.emit();
  }

  /** All frames up to the last pose, controls going straight from one pose to the next; null where there is no pose. */
  clip(): Clip | null {
    const last = this.#all.at(-1);
    if (!last) return null;
    const frames = last.frame + 1;
    const width = last.values.length;
    const controls = new Float32Array(frames * width);
    for (let frame = 0, next = 0; frame < frames; ++frame) {
      while (this.#all[next].frame < frame) ++next;
      const to = this.#all[next];
      const from = this.#all[next - 1] ?? to;
      const share = to.frame === from.frame ? 1 : (frame - from.frame) / (to.frame - from.frame);
      for (let c = 0; c < width; ++c)
        controls[frame * width + c] = share === 1 ? to.values[c] : from.values[c] + share * (to.values[c] - from.values[c]);
    }
    return { name: "Keyframes", origin: "this page", fps: KEYFRAME_RATE, frames, controls, notes: [] };
  }

  #freeFrame(asked: number): number {
    const taken = new Set(this.#all.map(({ frame }) => frame));
    let frame = Math.min(Math.max(Math.round(asked), 0), MOST_FRAMES - 1);
    while (taken.has(frame)) ++frame;
    return frame;
  }
}

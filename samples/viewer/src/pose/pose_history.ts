import { Signal } from "../app/signal";

const MOST_STEPS = 200;

/** Poses to go back to. A step is what was done to the pose from one end() to the next: all of a drag is one. */
export class PoseHistory {
  readonly changed = new Signal();
  readonly #undone: Float32Array[] = [];
  readonly #done: Float32Array[] = [];
  #open = false;

  /** The pose will be changed by somebody; `before`: as it is now. */
  begin(before: Float32Array): void {
    if (this.#open) return;
    this.#open = true;
    this.#undone.length = 0;
    this.#done.push(before.slice());
    if (this.#done.length > MOST_STEPS) this.#done.shift();
    this.changed.emit();
  }

  /** A step ends; it is none where the pose is as before. */
  end(now: Float32Array): void {
    if (!this.#open) return;
    this.#open = false;
    if (same(this.#done.at(-1)!, now)) this.#done.pop();
    this.changed.emit();
  }

  get canUndo(): boolean {
    return this.#done.length > 0;
  }
  get canRedo(): boolean {
    return this.#undone.length > 0;
  }

  /** The pose before the last step, which is undone from `now`; null where there is none. */
  undo(now: Float32Array): Float32Array | null {
    return this.#move(this.#done, this.#undone, now);
  }

  /** The pose after the step that was undone last. */
  redo(now: Float32Array): Float32Array | null {
    return this.#move(this.#undone, this.#done, now);
  }

  #move(from: Float32Array[], to: Float32Array[], now: Float32Array): Float32Array | null {
    this.#open = false;
    const pose = from.pop();
    if (!pose) return null;
    to.push(now.slice());
    this.changed.emit();
    return pose;
  }
}

const same = (a: Float32Array, b: Float32Array): boolean => a.every((value, i) => value === b[i]);

import { Signal } from "../app/signal";
import type { Clip } from "./clip";

/** Plays a clip: which frame it is. */
export class Player {
  readonly changed = new Signal();
  #clip: Clip | null = null;
  #frame = 0;
  #playing = false;
  #started = 0; // when frame 0 was, or would have been, in milliseconds

  get clip(): Clip | null {
    return this.#clip;
  }
  get frame(): number {
    return this.#frame;
  }
  get playing(): boolean {
    return this.#playing;
  }

  open(clip: Clip | null): void {
    this.#clip = clip;
    this.#playing = false;
    this.#frame = 0;
    this.changed.emit();
  }

  toggle(): void {
    if (!this.#clip) return;
    this.#playing = !this.#playing;
    this.#started = performance.now() - (this.#frame / this.#clip.fps) * 1000;
    this.changed.emit();
  }

  /** Stops at a frame. */
  seek(frame: number): void {
    if (!this.#clip) return;
    this.#playing = false;
    this.#frame = Math.min(Math.max(Math.round(frame), 0), this.#clip.frames - 1);
    this.changed.emit();
  }

  /** To be called before each picture; returns whether the frame is another. At the end it begins again. */
  advance(now: number): boolean {
    if (!this.#clip || !this.#playing) return false;
    const frame = Math.floor(((now - this.#started) / 1000) * this.#clip.fps) % this.#clip.frames;
    if (frame === this.#frame || frame < 0) return false;
    this.#frame = frame;
    this.changed.emit();
    return true;
  }

  /** The controls of the frame. */
  controls(): Float32Array | null {
    if (!this.#clip) return null;
    const width = this.#clip.controls.length / this.#clip.frames;
    return this.#clip.controls.subarray(this.#frame * width, (this.#frame + 1) * width);
  }
}

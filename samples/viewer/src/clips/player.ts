import { Signal } from "../app/signal";
import type { Clip } from "./clip";

/** How fast a clip can be played, of its own speed. */
export const SPEEDS: readonly number[] = [0.25, 0.5, 1, 2];

/** Plays a clip: which frame it is. */
export class Player {
  /** It is at a frame, whose pose is to be shown. */
  readonly moved = new Signal();
  /** That, or it plays, pauses, or plays otherwise. */
  readonly changed = new Signal();
  #loop = true;
  #speed = 1;
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
  /** Whether a clip begins again at its end. */
  get loop(): boolean {
    return this.#loop;
  }
  set loop(loop: boolean) {
    this.#loop = loop;
    this.changed.emit();
  }
  /** See SPEEDS. */
  get speed(): number {
    return this.#speed;
  }
  set speed(speed: number) {
    this.#speed = speed;
    this.#setStart(performance.now());
    this.changed.emit();
  }

  open(clip: Clip | null): void {
    this.#clip = clip;
    this.#playing = false;
    this.#moveTo(0);
  }

  /** Plays or pauses; from its last frame on a clip begins again. */
  toggle(): void {
    if (!this.#clip) return;
    if (this.#playing) return this.pause();
    this.#playing = true;
    if (this.#frame === this.#clip.frames - 1) this.#frame = 0;
    this.#setStart(performance.now());
    this.#moveTo(this.#frame);
  }

  pause(): void {
    if (!this.#playing) return;
    this.#playing = false;
    this.changed.emit();
  }

  /** Stops at a frame. */
  seek(frame: number): void {
    if (!this.#clip) return;
    this.#playing = false;
    this.#moveTo(Math.min(Math.max(Math.round(frame), 0), this.#clip.frames - 1));
  }

  /** To be called before each picture; returns whether the frame is another. */
  advance(now: number): boolean {
    if (!this.#clip || !this.#playing) return false;
    const { frames } = this.#clip;
    const count = Math.floor((now - this.#started) / this.#frameTime());
    const ended = !this.#loop && count >= frames - 1;
    const frame = ended ? frames - 1 : count % frames;
    if (!ended && (frame === this.#frame || frame < 0)) return false;
    this.#playing = !ended;
    this.#moveTo(frame);
    return true;
  }

  /** The controls of the frame. */
  controls(): Float32Array | null {
    if (!this.#clip) return null;
    const width = this.#clip.controls.length / this.#clip.frames;
    return this.#clip.controls.subarray(this.#frame * width, (this.#frame + 1) * width);
  }

  #moveTo(frame: number): void {
    this.#frame = frame;
    this.moved.emit();
    this.changed.emit();
  }

  /** Milliseconds. */
  #frameTime(): number {
    return 1000 / ((this.#clip?.fps ?? 1) * this.#speed);
  }

  /** It is at its frame now. */
  #setStart(now: number): void {
    this.#started = now - this.#frame * this.#frameTime();
  }
}

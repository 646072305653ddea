import { tokenHeaders } from "./access_token";
import { Signal } from "./signal";
import type { Viewer } from "./viewer";

const RETRY = 2000; // milliseconds after the server has not answered

/** Where facial capture is asked for, and where `facebaker view` takes its packets: "capture" of view.json. */
export interface CaptureSource {
  url: string;
  source: string;
  address: string;
  port: number;
}

/** What `facebaker view` says of the capture: the latest frame, whatever came before it. */
export interface CaptureNews {
  source: string;
  /** What the sender calls itself, or "". */
  subject: string;
  /** All that came. */
  frames: number;
  /** In the last second. */
  fps: number;
  /** Seconds since the last frame, and since the last packet, such as one without a face; null before the first. */
  frame_age: number | null;
  packet_age: number | null;
  /** Packets that were none. */
  refused: number;
  /** How many names are captured, and which of them have no control. */
  names: number;
  unmatched_count: number;
  unmatched: string[];
  /** What the performer is to do for a calibration now, or "". */
  calibrating: string;
  /** Names of controls, and a value of each. */
  controls: string[];
  values: number[];
}

/**
 * Facial capture that drives the pose: before each picture the latest frame is asked for, unless the answer before is
 * still on its way, so that no frames pile up. Controls that are not captured stay as they are.
 */
export class Capture {
  /** Other news, or none. */
  readonly changed = new Signal();
  news: CaptureNews | null = null;
  /** Why there are none; null where there are. */
  failure: string | null = null;
  #held = false;
  #frames = 0; // of the news that were shown last
  #waiting = false;
  #notBefore = 0;

  constructor(
    readonly viewer: Viewer,
    readonly source: CaptureSource,
  ) {
    viewer.started.subscribe(() => {
      this.#frames = 0;
    });
  }

  /** Whether frames are left out, so that the pose can be edited. */
  get held(): boolean {
    return this.#held;
  }
  set held(held: boolean) {
    this.#held = held;
    this.changed.emit();
  }

  start(): void {
    const turn = (now: number): void => {
      requestAnimationFrame(turn);
      if (!this.#waiting && now >= this.#notBefore) void this.#ask();
    };
    requestAnimationFrame(turn);
  }

  async #ask(): Promise<void> {
    this.#waiting = true;
    try {
      const answer = await fetch(`./${this.source.url}`, { headers: tokenHeaders() });
      if (!answer.ok) throw new Error((await answer.text()).trim());
      this.news = (await answer.json()) as CaptureNews;
      this.failure = null;
      this.#show(this.news);
    } catch (error) {
      this.news = null;
      this.failure = error instanceof TypeError ? "facebaker view does not answer" : String((error as Error).message);
      this.#notBefore = performance.now() + RETRY;
    } finally {
      this.#waiting = false;
    }
    this.changed.emit();
  }

  #show({ frames, controls, values }: CaptureNews): void {
    if (this.#held || frames === this.#frames) return;
    this.#frames = frames;
    const { pose, player } = this.viewer;
    player.pause();
    const indices = new Map(pose.controls.map((control, index) => [control.name, index]));
    const next = pose.values.slice();
    controls.forEach((name, i) => {
      const index = indices.get(name);
      if (index !== undefined) next[index] = values[i];
    });
    pose.follow(next);
  }
}

const KEPT = 120; // the last poses, over which clocks that tick slowly average out
const WARM_UP = 3; // the first poses, which are compiled while they run

/** How long poses took. */
export class PoseTimes {
  #milliseconds: number[] = [];
  #skipped = 0;

  add(milliseconds: number): void {
    if (this.#skipped++ < WARM_UP) return;
    this.#milliseconds.push(milliseconds);
    if (this.#milliseconds.length > KEPT) this.#milliseconds.shift();
  }

  clear(): void {
    this.#milliseconds = [];
    this.#skipped = 0;
  }

  /** Microseconds a pose, the mean without the slowest tenth; null before there was any. */
  get microseconds(): number | null {
    const sorted = [...this.#milliseconds].sort((a, b) => a - b);
    const kept = sorted.slice(0, Math.max(1, Math.ceil(sorted.length * 0.9)));
    if (kept.length === 0 || sorted.length === 0) return null;
    return (1000 * kept.reduce((sum, time) => sum + time, 0)) / kept.length;
  }
}

import type { Control } from "facebaker";
import { Signal } from "../app/signal";
import { findPairs } from "./control_pairs";

/** The values of all controls of a face, and who is to know when they change. */
export class Pose {
  readonly values: Float32Array;
  readonly rest: Float32Array;
  /** See findPairs. */
  readonly partners: Int32Array;
  readonly changed = new Signal();
  /** Whether set() moves the control of the other side too. */
  linked = false;

  constructor(readonly controls: readonly Control[]) {
    this.rest = Float32Array.from(controls, (control) => control.neutral);
    this.values = this.rest.slice();
    this.partners = findPairs(controls);
  }

  get hasPairs(): boolean {
    return this.partners.some((partner) => partner >= 0);
  }

  set(index: number, value: number): void {
    this.#put(index, value);
    const partner = this.partners[index];
    if (this.linked && partner >= 0) this.#put(partner, this.#mirrored(index, partner));
    this.changed.emit();
  }

  /** All controls; values outside their ranges are clamped. */
  assign(values: ArrayLike<number>): void {
    for (let index = 0; index < this.values.length; ++index) this.#put(index, values[index]);
    this.changed.emit();
  }

  /** Back to rest: the controls given, or all of them. */
  reset(indices?: Iterable<number>): void {
    if (indices === undefined) this.values.set(this.rest);
    else for (const index of indices) this.values[index] = this.rest[index];
    this.changed.emit();
  }

  isAtRest(index: number): boolean {
    return this.values[index] === this.rest[index];
  }

  /** Controls that are not at rest. */
  movedCount(): number {
    let count = 0;
    for (let index = 0; index < this.values.length; ++index) if (!this.isAtRest(index)) ++count;
    return count;
  }

  #put(index: number, value: number): void {
    const { minimum, maximum } = this.controls[index];
    this.values[index] = Math.min(Math.max(value, minimum), maximum);
  }

  /** As far from rest, relative to the end of the range that lies there. */
  #mirrored(index: number, partner: number): number {
    const from = this.controls[index];
    const to = this.controls[partner];
    if (from.minimum === to.minimum && from.maximum === to.maximum && from.neutral === to.neutral) return this.values[index];
    const moved = this.values[index] - from.neutral;
    const share = moved >= 0 ? moved / (from.maximum - from.neutral || 1) : -moved / (from.minimum - from.neutral || 1);
    return to.neutral + (share >= 0 ? share * (to.maximum - to.neutral) : -share * (to.minimum - to.neutral));
  }
}

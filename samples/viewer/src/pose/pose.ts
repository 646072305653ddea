import type { Control } from "facebaker";
import { Signal } from "../app/signal";
import { findPairs } from "./control_pairs";
import { PoseHistory } from "./pose_history";
import { randomPose } from "./random_pose";

/** The values of all controls of a face, and who is to know when they change. */
export class Pose {
  readonly values: Float32Array;
  readonly rest: Float32Array;
  /** See findPairs. */
  readonly partners: Int32Array;
  readonly changed = new Signal();
  /** Somebody edits it: it is no longer what a clip has. */
  readonly edited = new Signal();
  readonly history = new PoseHistory();
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

  /** Edits a control; what is done until endStep() is undone at once. Values outside their ranges are clamped. */
  set(index: number, value: number): void {
    this.#edit(() => {
      this.#put(index, value);
      const partner = this.partners[index];
      if (this.linked && partner >= 0) this.#put(partner, this.mirrored(index, partner, this.values[index]));
    });
  }

  /** Edits all controls; what is done until endStep() is undone at once. */
  move(values: ArrayLike<number>): void {
    this.#edit(() => {
      for (let index = 0; index < this.values.length; ++index) this.#put(index, values[index]);
    });
  }

  endStep(): void {
    this.history.end(this.values);
  }

  /** Shows the pose of a clip, which is no edit. */
  follow(values: ArrayLike<number>): void {
    this.endStep();
    for (let index = 0; index < this.values.length; ++index) this.#put(index, values[index]);
    this.changed.emit();
  }

  /** Edits all controls in one step. */
  assign(values: ArrayLike<number>): void {
    this.endStep();
    this.move(values);
    this.endStep();
  }

  /** Back to rest, in one step: the controls given, or all of them. */
  reset(indices?: Iterable<number>): void {
    const values = this.values.slice();
    if (indices === undefined) values.set(this.rest);
    else for (const index of indices) values[index] = this.rest[index];
    this.assign(values);
  }

  randomise(): void {
    this.assign(randomPose(this));
  }

  undo(): void {
    this.#restore(this.history.undo(this.values));
  }

  redo(): void {
    this.#restore(this.history.redo(this.values));
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

  /** The value of a partner of a control that has this value: as far from rest, relative to the end of the range that lies
   * there. */
  mirrored(index: number, partner: number, value: number): number {
    const from = this.controls[index];
    const to = this.controls[partner];
    if (from.minimum === to.minimum && from.maximum === to.maximum && from.neutral === to.neutral) return value;
    const moved = value - from.neutral;
    const share = moved >= 0 ? moved / (from.maximum - from.neutral || 1) : -moved / (from.minimum - from.neutral || 1);
    return to.neutral + (share >= 0 ? share * (to.maximum - to.neutral) : -share * (to.minimum - to.neutral));
  }

  #edit(change: () => void): void {
    this.edited.emit();
    this.history.begin(this.values);
    change();
    this.changed.emit();
  }

  #restore(values: Float32Array | null): void {
    if (!values) return;
    this.edited.emit();
    this.values.set(values);
    this.changed.emit();
  }

  #put(index: number, value: number): void {
    const { minimum, maximum } = this.controls[index];
    this.values[index] = Math.min(Math.max(value, minimum), maximum);
  }
}

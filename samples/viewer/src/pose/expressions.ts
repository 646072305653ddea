import { Signal } from "../app/signal";

/** A pose with a name. */
export interface Expression {
  name: string;
  /** Of all controls. */
  values: Float32Array;
}

/** What separates cells of a .csv, and lines, would break the file that names are saved in. */
const plainName = (name: string): string => name.replace(/[",;\s]+/g, " ").trim();

/** The expressions of a face that were kept, in the order in which they were. */
export class ExpressionList {
  readonly changed = new Signal();
  #all: readonly Expression[] = [];

  get all(): readonly Expression[] {
    return this.#all;
  }

  /** Others in place of all. */
  replace(all: readonly Expression[]): void {
    this.#all = all;
    this.changed.emit();
  }

  /** Keeps a pose; without a name it gets one, and another one where there is one of that name. Returns the name. */
  keep(name: string, values: Float32Array): string {
    const free = this.#freeName(plainName(name) || "Expression");
    this.replace([...this.#all, { name: free, values: values.slice() }]);
    return free;
  }

  /** Those of a file; what is there already, by its name and pose, is not kept twice. Returns how many are new. */
  add(expressions: readonly Expression[]): number {
    const before = this.#all.length;
    for (const { name, values } of expressions)
      if (!this.#all.some((kept) => kept.name === plainName(name) && kept.values.every((value, i) => value === values[i])))
        this.keep(name, values);
    return this.#all.length - before;
  }

  remove(expression: Expression): void {
    this.replace(this.#all.filter((kept) => kept !== expression));
  }

  #freeName(name: string): string {
    const taken = new Set(this.#all.map((kept) => kept.name));
    let free = name;
    for (let count = 2; taken.has(free); ++count) free = `${name} ${count}`;
    return free;
  }
}

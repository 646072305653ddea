import type { Control } from "facebaker";
import type { Pose } from "../pose/pose";
import { element } from "./dom";
import { figure } from "./number_text";

/** A control: a slider, its number, and a button that puts it to rest. */
export class ControlRow {
  readonly element: HTMLElement;
  readonly #slider: HTMLInputElement;
  readonly #number: HTMLInputElement;
  readonly #words: string;
  #shown = NaN;

  constructor(
    readonly control: Control,
    readonly pose: Pose,
  ) {
    const { name, minimum, maximum, unit, arkit, facs, index } = control;
    const step = (maximum - minimum) / 1000;
    const title = [name, arkit && arkit !== name ? `ARKit ${arkit}` : "", facs, `${figure(minimum)} to ${figure(maximum)}${unit ? ` ${unit}` : ""}`];
    this.#words = [name, arkit, facs, control.group].join(" ").toLowerCase();
    this.#slider = element("input", { type: "range", min: minimum, max: maximum, step: "any", "aria-label": name });
    this.#number = element("input", { type: "number", min: minimum, max: maximum, step: "any", "aria-label": `${name}, number` });
    const reset = element("button", { type: "button", "aria-label": `Reset ${name}`, title: "To rest" }, "↺");
    const label = element("span", { class: "label", title: title.filter(Boolean).join(" · ") }, name);
    this.element = element("div", { class: "control" }, label, this.#number, reset, this.#slider);
    this.#slider.addEventListener("input", () => pose.set(index, this.#slider.valueAsNumber));
    // A drag is a step of the history, and so is holding a key.
    for (const event of ["pointerdown", "change", "keyup"]) this.#slider.addEventListener(event, () => pose.endStep());
    this.#slider.addEventListener("dblclick", () => pose.reset([index]));
    this.#slider.addEventListener("keydown", (event) => this.#nudge(event, step));
    this.#number.addEventListener("change", () => {
      if (Number.isFinite(this.#number.valueAsNumber)) pose.set(index, this.#number.valueAsNumber);
      pose.endStep();
      this.#shown = NaN;
      this.show();
    });
    reset.addEventListener("click", () => {
      pose.reset([index]);
      this.#slider.focus();
    });
  }

  get moved(): boolean {
    return !this.pose.isAtRest(this.control.index);
  }

  /** Hides the row unless all words are in its names; returns whether it is to be seen. */
  match(words: readonly string[]): boolean {
    const found = words.every((word) => this.#words.includes(word));
    this.element.hidden = !found;
    return found;
  }

  show(): void {
    const value = this.pose.values[this.control.index];
    if (value === this.#shown) return;
    this.#shown = value;
    this.#slider.valueAsNumber = value;
    if (document.activeElement !== this.#number) this.#number.value = String(Number(value.toPrecision(4)));
    this.element.classList.toggle("moved", this.moved);
  }

  /** With step "any" browsers move a slider by 1: a fiftieth of the range is meant, with Shift a thousandth. */
  #nudge(event: KeyboardEvent, step: number): void {
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (way === undefined) return;
    this.pose.set(this.control.index, this.pose.values[this.control.index] + way * step * (event.shiftKey ? 1 : 20));
    event.preventDefault();
  }
}

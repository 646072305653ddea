import type { Viewer } from "../app/viewer";
import { element } from "./dom";
import { lengthText } from "./number_text";

const SVG = "http://www.w3.org/2000/svg";
const TOP = 4; // of 100: the worst frame is not at the very edge

function svgElement(tag: string, attributes: Record<string, string>): SVGElement {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

/** The path of what is known of a curve, in a box that is frames - 1 wide and 100 high. */
function pathOf(values: Float32Array, largest: number): string {
  let path = "";
  let gap = true;
  for (let frame = 0; frame < values.length; ++frame) {
    if (Number.isNaN(values[frame])) {
      gap = true;
      continue;
    }
    const y = (100 - ((100 - TOP) * values[frame]) / (largest || 1)).toFixed(1);
    path += gap ? `M${frame} ${y}h.01` : `L${frame} ${y}`;
    gap = false;
  }
  return path;
}

/** The largest error of each frame of the clip, as a curve: a click or a drag goes to a frame, the button to the next worst
 * one. Hidden where nothing is known of the clip. */
export class ErrorCurveView {
  readonly element: HTMLElement;
  readonly #line = svgElement("path", { class: "line", "vector-effect": "non-scaling-stroke" });
  readonly #drawing = svgElement("svg", { preserveAspectRatio: "none", "aria-hidden": "true" });
  readonly #head = element("div", { class: "playhead" });
  readonly #words = element("p", {});
  readonly #box = element("div", { class: "curve", role: "img" }, this.#head, this.#words);
  readonly #next = element("button", { type: "button", title: "The worst frame, then the next worst (W)" }, "Next worst");
  #largest = 0;
  #asked = false;

  constructor(readonly viewer: Viewer) {
    this.#drawing.append(this.#line);
    this.#box.prepend(this.#drawing);
    this.element = element("div", { class: "curve-row" }, this.#box, this.#next);
    this.#next.addEventListener("click", () => viewer.seekNextWorst());
    this.#box.addEventListener("pointerdown", (event) => {
      this.#box.setPointerCapture(event.pointerId);
      this.#seek(event);
    });
    this.#box.addEventListener("pointermove", (event) => {
      if (this.#box.hasPointerCapture(event.pointerId)) this.#seek(event);
    });
    viewer.curve.changed.subscribe(() => this.#drawSoon());
    viewer.player.changed.subscribe(() => this.#showFrame());
    this.#draw();
  }

  #seek(event: PointerEvent): void {
    const { clip } = this.viewer.player;
    const { left, width } = this.#box.getBoundingClientRect();
    if (clip) this.viewer.player.seek(((event.clientX - left) / width) * (clip.frames - 1));
  }

  /** Once a picture, however often it changes. */
  #drawSoon(): void {
    if (this.#asked) return;
    this.#asked = true;
    requestAnimationFrame(() => {
      this.#asked = false;
      this.#draw();
    });
  }

  #draw(): void {
    const { curve, player } = this.viewer;
    const { largest } = curve;
    this.element.hidden = curve.measured === 0 && player.clip?.reference === undefined;
    this.#largest = largest.reduce((most, value) => (value > most ? value : most), 0);
    this.#drawing.setAttribute("viewBox", `0 0 ${Math.max(largest.length - 1, 1)} 100`);
    this.#line.setAttribute("d", pathOf(largest, this.#largest));
    const worst = curve.peaks[0];
    const summary = worst === undefined ? "" : ` The worst is ${this.#length(this.#largest)}, at frame ${worst + 1}.`;
    this.#box.setAttribute("aria-label", `Largest error of each frame, as a curve.${summary}`);
    this.#next.disabled = worst === undefined;
    this.#showFrame();
  }

  #showFrame(): void {
    const { curve, player } = this.viewer;
    if (this.element.hidden || !player.clip) return;
    const { frames } = player.clip;
    this.#head.style.left = `${(100 * player.frame) / Math.max(frames - 1, 1)}%`;
    const words = this.#wordsOf(curve.largest[player.frame]);
    if (this.#words.textContent !== words) this.#words.textContent = words;
  }

  #length(error: number): string {
    return lengthText(error, this.viewer.first?.face.units ?? "");
  }

  #wordsOf(here: number): string {
    const { curve } = this.viewer;
    if (curve.measured === 0) return curve.gaveUp ? "The true positions could not be read." : "Reading the true positions…";
    const done = curve.measuring ? ` · measuring, ${Math.floor((100 * curve.measured) / curve.largest.length)} %` : "";
    const now = Number.isNaN(here) ? "" : `${this.#length(here)}, `;
    return `Error ${now}worst ${this.#length(this.#largest)}${done}`;
  }
}

import type { Viewer } from "../app/viewer";
import { gradientStops, partColour } from "../scene/colour_scale";
import { byId, element } from "./dom";
import { errorText, figure, lengthText } from "./number_text";

const SCALES = [1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 1e-5];

/** What the colours mean: a scale in millimetres and in fractions of the diagonal, or the names of regions. */
export function startLegend(viewer: Viewer): void {
  const legend = byId("legend");
  const title = element("h2");
  const scale = element("div", { class: "scale", "aria-hidden": "true" });
  scale.style.background = `linear-gradient(90deg, ${gradientStops()})`;
  const lengths = element("div", { class: "ticks" });
  const fractions = element("div", { class: "ticks" });
  const words = element("p", { role: "status" });
  const choice = element("select", { id: "scale-end" });
  choice.append(element("option", { value: "" }, "of this pose"));
  for (const end of SCALES) choice.append(element("option", { value: String(end) }, `${figure(end)} D`));
  choice.addEventListener("change", () => viewer.setScale(choice.value === "" ? null : Number(choice.value)));
  const chooser = element("label", {}, "Scale", choice);
  const list = element("ul", { tabindex: "0", "aria-label": "Regions" });
  legend.append(title, scale, lengths, fractions, words, chooser, list);

  const showRegions = (): void => {
    const names = viewer.first?.face.regions.names ?? [];
    list.replaceChildren(
      ...names.map((name, i) => {
        const swatch = element("span", { class: "swatch" });
        swatch.style.background = partColour(i);
        return element("li", {}, swatch, name);
      }),
    );
  };
  const show = (): void => {
    const { mode, first } = viewer;
    const scaled = mode === "expected" || mode === "error" || mode === "difference";
    legend.hidden = first === null || !(scaled || mode === "regions");
    if (legend.hidden || !first) return;
    const { units, diagonal } = first.face;
    for (const part of [scale, lengths, fractions, words, chooser]) part.hidden = !scaled;
    list.hidden = scaled;
    if (!scaled) {
      title.textContent = "Regions of expected errors";
      return;
    }
    const ends = [0, 0.5, 1].map((share) => share * viewer.scaleEnd);
    lengths.replaceChildren(...ends.map((end) => element("span", {}, lengthText(end, units))));
    fractions.replaceChildren(...ends.map((end) => element("span", {}, `${figure(end / diagonal)} D`)));
    title.textContent = { expected: "Expected error", error: "Error", difference: "Difference" }[mode as "error"];
    words.textContent = wordsOf(viewer, units, diagonal);
  };
  viewer.opened.subscribe(showRegions);
  viewer.drawn.subscribe(show);
  viewer.modeChanged.subscribe(show);
}

function wordsOf(viewer: Viewer, units: string, diagonal: number): string {
  const { mode, expected, errors } = viewer;
  if (mode === "expected" && expected) {
    const outside = expected.outside > 0 ? ` ${expected.outside} controls are outside of what was trained.` : "";
    return `Root mean square ${errorText(expected.face, units, diagonal)}.${outside}`;
  }
  if (errors) {
    const { names, ofVertex } = viewer.first!.face.regions;
    const region = names[ofVertex[errors.worst] ?? -1];
    const where = region === undefined ? `at vertex ${errors.worst}` : `in ${region}, vertex ${errors.worst}`;
    return `Worst vertex off by ${errorText(errors.max, units, diagonal)} ${where}. Root mean square ${errorText(errors.rms, units, diagonal)}.`;
  }
  if (viewer.truth?.live) return "The rig is being evaluated…";
  return viewer.player.clip?.reference
    ? "Reading the true positions; they are of the clip's own frames."
    : "Play a clip that has true positions.";
}

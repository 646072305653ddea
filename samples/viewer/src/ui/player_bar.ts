import type { Viewer } from "../app/viewer";
import { SPEEDS } from "../clips/player";
import { byId, element } from "./dom";
import { ErrorCurveView } from "./error_curve_view";

/** How fast, and whether again and again. */
function makeChoices(viewer: Viewer): { speed: HTMLSelectElement; loop: HTMLButtonElement } {
  const { player } = viewer;
  const speed = element("select", { "aria-label": "Speed", title: "Speed" });
  for (const value of SPEEDS) speed.append(element("option", { value, selected: value === player.speed }, `${value}×`));
  speed.addEventListener("change", () => {
    player.speed = Number(speed.value);
  });
  const loop = element("button", { type: "button", title: "Begin again at the end (L)" }, "Loop");
  loop.addEventListener("click", () => {
    player.loop = !player.loop;
  });
  return { speed, loop };
}

/** Plays and scrubs the clip, and shows its errors over time. */
export function startPlayerBar(viewer: Viewer): void {
  const { player } = viewer;
  const bar = byId("player");
  const play = element("button", { type: "button", class: "icon" });
  const name = element("span", { class: "name" });
  const scrub = element("input", { type: "range", min: 0, max: 0, step: 1, "aria-label": "Frame" });
  const frame = element("output", {});
  const { speed, loop } = makeChoices(viewer);
  bar.append(new ErrorCurveView(viewer).element, element("div", { class: "play-row" }, play, name, scrub, frame, speed, loop));
  play.addEventListener("click", () => player.toggle());
  scrub.addEventListener("input", () => player.seek(scrub.valueAsNumber));
  player.changed.subscribe(() => {
    const { clip } = player;
    bar.hidden = clip === null;
    if (!clip) return;
    const words = player.playing ? "Pause" : "Play";
    if (play.title !== `${words} (Space)`) {
      play.title = `${words} (Space)`;
      play.setAttribute("aria-label", words);
      play.textContent = player.playing ? "❚❚" : "▶";
    }
    loop.setAttribute("aria-pressed", String(player.loop));
    name.textContent = clip.name;
    name.title = clip.name;
    scrub.max = String(clip.frames - 1);
    scrub.valueAsNumber = player.frame;
    scrub.setAttribute("aria-valuetext", `frame ${player.frame + 1} of ${clip.frames}`);
    frame.textContent = `${player.frame + 1} / ${clip.frames}`;
  });
}

import type { Viewer } from "../app/viewer";
import { byId, element } from "./dom";

/** Plays and scrubs the clip. */
export function startPlayerBar(viewer: Viewer): void {
  const { player } = viewer;
  const bar = byId("player");
  const play = element("button", { type: "button", class: "icon" });
  const name = element("span", { class: "name" });
  const scrub = element("input", { type: "range", min: 0, max: 0, step: 1, "aria-label": "Frame" });
  const frame = element("output", {});
  bar.append(play, name, scrub, frame);
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
    name.textContent = clip.name;
    name.title = clip.name;
    scrub.max = String(clip.frames - 1);
    scrub.valueAsNumber = player.frame;
    scrub.setAttribute("aria-valuetext", `frame ${player.frame + 1} of ${clip.frames}`);
    frame.textContent = `${player.frame + 1} / ${clip.frames}`;
  });
}

import type { Viewer } from "../app/viewer";
import { byId, element } from "./dom";
import { figure } from "./number_text";

/** The list of clips. */
export function startClipsPanel(viewer: Viewer, open: () => void, openFolder: () => void): void {
  const panel = element("div");
  byId("clips").append(panel);
  const show = (): void => {
    const list = element("ul", { class: "clips" });
    for (const clip of viewer.clips) {
      const seconds = clip.frames / clip.fps;
      const button = element(
        "button",
        { type: "button", "aria-current": viewer.player.clip === clip ? "true" : undefined },
        element("span", { class: "title" }, clip.name),
        element("span", { class: "length" }, `${clip.frames} frames, ${figure(seconds)} s`),
        element("span", { class: "where" }, clip.reference ? `${clip.origin} · true positions` : clip.origin),
      );
      button.addEventListener("click", () => viewer.openClip(clip));
      list.append(element("li", {}, button));
    }
    const notes = (viewer.player.clip?.notes ?? []).map((note) => element("p", { class: "hint" }, note));
    const openFiles = element("button", { type: "button" }, "Open clips…");
    const openDataset = element("button", { type: "button" }, "Open a dataset folder…");
    const close = element("button", { type: "button", hidden: viewer.player.clip === null }, "Close the clip");
    openFiles.addEventListener("click", open);
    openDataset.addEventListener("click", openFolder);
    close.addEventListener("click", () => viewer.openClip(null));
    panel.replaceChildren(
      ...(viewer.clips.length > 0 ? [list] : [element("p", { class: "none" }, "No clips yet.")]),
      ...notes,
      element("div", { class: "row" }, openFiles, openDataset, close),
      element(
        "p",
        { class: "hint" },
        "A NumPy file of frames × controls (.npy), a take of Live Link Face (.csv), or a dataset folder, whose true positions show the error. They can be dropped onto the face, too.",
      ),
    );
  };
  viewer.clipsChanged.subscribe(show);
  show();
}

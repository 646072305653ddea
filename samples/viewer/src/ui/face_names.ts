import type { Viewer } from "../app/viewer";
import { byId, element } from "./dom";

/** What stands over the faces, from left to right, where there are several. */
function namesOver({ faces, trueRig }: Viewer): string[] {
  if (!trueRig) return faces.length > 1 ? faces.map(({ name }) => name) : [];
  return [...faces.map(({ name }) => name), trueRig.visible ? "True rig" : "True rig: not known here"];
}

/** The names of the faces: over the picture, in the head of the page, and of the page. */
export function startFaceNames(viewer: Viewer): void {
  const list = byId("names");
  let shown = "";
  const showOver = (): void => {
    const names = namesOver(viewer);
    if (shown === names.join("\n")) return;
    shown = names.join("\n");
    list.hidden = names.length === 0;
    list.replaceChildren(...names.map((name) => element("span", {}, element("b", {}, name))));
  };
  viewer.opened.subscribe(() => {
    const { faces } = viewer;
    const title = faces.map(({ face, name }) => (faces.length > 1 ? name : face.name || name)).join(" and ");
    byId("title").textContent = title;
    document.title = `${title} · FaceBaker viewer`;
    showOver();
  });
  viewer.drawn.subscribe(showOver);
}

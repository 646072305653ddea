import { readRights, today } from "../app/face_rights";
import type { ShownFace } from "../app/open_faces";
import type { Viewer } from "../app/viewer";
import { byId, element } from "./dom";

/** What binds of a face's rights: an end that is past stands alone, the rest is behind a line that can be opened. */
function lineOf({ face, name }: ShownFace, several: boolean): HTMLElement[] {
  const { expired, binding } = readRights(face.about, today());
  if (binding.length === 0) return [];
  const of = several ? `${face.name || name}: ` : "";
  const ended = expired ? [element("p", { class: "expired" }, of + binding[0])] : [];
  const rest = expired ? binding.slice(1) : binding;
  if (rest.length === 0) return ended;
  const list = element("ul", {}, ...rest.map((clause) => element("li", {}, clause)));
  const summary = element("summary", {}, rest.length === 1 ? `${of}1 right binds` : `${of}${rest.length} rights bind`);
  return [...ended, element("details", {}, summary, list)];
}

/** Says over the panel what the faces' rights bind to. */
export function startRightsLine(viewer: Viewer): void {
  const line = byId("rights");
  const show = (): void => {
    const parts = viewer.faces.flatMap((face) => lineOf(face, viewer.faces.length > 1));
    line.hidden = parts.length === 0;
    line.replaceChildren(...parts);
  };
  viewer.opened.subscribe(show);
  show();
}

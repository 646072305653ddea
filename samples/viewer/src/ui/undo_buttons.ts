import type { Viewer } from "../app/viewer";
import { element } from "./dom";

const ARROW =
  '<svg viewBox="0 0 20 20" aria-hidden="true"><path d="M8 4 4 8l4 4M4.5 8H12a4 4 0 0 1 0 8H8" fill="none" ' +
  'stroke="currentColor" stroke-width="1.8" stroke-linecap="round" stroke-linejoin="round" /></svg>';

/** Undo and redo of what was done to the pose. */
export class UndoButtons {
  readonly undo = element("button", { type: "button", class: "icon", "aria-label": "Undo", title: "Undo (Ctrl+Z)" });
  readonly redo = element("button", {
    type: "button",
    class: "icon mirrored",
    "aria-label": "Redo",
    title: "Redo (Ctrl+Shift+Z)",
  });

  constructor(readonly viewer: Viewer) {
    for (const button of [this.undo, this.redo]) button.innerHTML = ARROW;
    this.undo.addEventListener("click", () => viewer.pose.undo());
    this.redo.addEventListener("click", () => viewer.pose.redo());
  }

  /** Follows the pose of the face, which is another one. */
  follow(): void {
    const { history } = this.viewer.pose;
    const show = (): void => {
      this.undo.disabled = !history.canUndo;
      this.redo.disabled = !history.canRedo;
    };
    history.changed.subscribe(show);
    show();
  }
}

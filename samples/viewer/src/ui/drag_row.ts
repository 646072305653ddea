import type { FaceDragging } from "../app/face_dragging";
import { element } from "./dom";

const HOW = "Drag a point of the face, or Enter takes hold of the middle of the picture, arrow keys move it, Enter lets go.";

function stateOf(dragging: FaceDragging): string {
  if (dragging.loading) return "Loading the solver…";
  const { following } = dragging;
  if (following === null) return HOW;
  return `A point is held; ${following} ${following === 1 ? "control follows" : "controls follow"}.`;
}

/** Switches dragging on and off, and says what it does: a row of the pose panel, and a line below it. */
export class DragRow {
  readonly drag = element(
    "button",
    { type: "button", "aria-pressed": "false", title: "Drag points of the face; controls follow (D)" },
    "Drag points",
  );
  readonly openOnly = element(
    "button",
    { type: "button", "aria-pressed": "false", hidden: true, title: "Only controls of groups that are open follow" },
    "Open groups only",
  );
  readonly state = element("p", { class: "hint", role: "status" });

  constructor(dragging: FaceDragging) {
    this.drag.addEventListener("click", () => {
      dragging.on = !dragging.on;
    });
    this.openOnly.addEventListener("click", () => {
      dragging.openOnly = !dragging.openOnly;
      this.openOnly.setAttribute("aria-pressed", String(dragging.openOnly));
    });
    const show = (): void => {
      this.drag.setAttribute("aria-pressed", String(dragging.on));
      this.openOnly.hidden = !dragging.on;
      this.state.hidden = !dragging.on;
      const text = dragging.on ? stateOf(dragging) : "";
      if (this.state.textContent !== text) this.state.textContent = text;
    };
    dragging.changed.subscribe(show);
    show();
  }
}

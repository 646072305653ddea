import type { FaceDragging } from "../app/face_dragging";
import { byId, element } from "./dom";
import { tell } from "./messages";

const STEP = 4; // pixels that an arrow key moves the point; with Shift a quarter

/** Takes hold of a point; what is wrong with it is told. */
function hold(dragging: FaceDragging, x: number, y: number): boolean {
  try {
    return dragging.hold(x, y);
  } catch (error) {
    tell(error instanceof Error ? error.message : String(error));
    return true; // the face was meant
  }
}

/** The pointer drags points of the face, where it is on one; else it turns the face, as it does without. */
function watchPointer(canvas: HTMLCanvasElement, dragging: FaceDragging): void {
  let pointer: number | null = null;
  const taken = (event: PointerEvent): void => {
    event.preventDefault();
    event.stopImmediatePropagation(); // it does not turn the face
  };
  // Listeners of capturing come before those that turn the face.
  canvas.addEventListener(
    "pointerdown",
    (event) => {
      if (!dragging.on) return;
      if (pointer !== null) return taken(event);
      if (event.button !== 0 || event.shiftKey || event.ctrlKey || event.metaKey || event.altKey) return;
      dragging.release(); // what keys hold
      if (!hold(dragging, event.clientX, event.clientY)) return;
      taken(event);
      canvas.focus({ preventScroll: true });
      pointer = event.pointerId;
      canvas.setPointerCapture(pointer);
    },
    { capture: true },
  );
  canvas.addEventListener("pointermove", (event) => {
    if (event.pointerId === pointer) dragging.moveTo(event.clientX, event.clientY);
  });
  const end = (event: PointerEvent): void => {
    if (event.pointerId !== pointer) return;
    pointer = null;
    dragging.release();
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
}

/** Enter takes hold of the point in the middle of the picture, arrows move it, Enter lets go, Escape takes it back. */
function watchKeys(canvas: HTMLCanvasElement, dragging: FaceDragging): void {
  const ways: Record<string, [number, number]> = {
    ArrowLeft: [-STEP, 0],
    ArrowRight: [STEP, 0],
    ArrowUp: [0, -STEP],
    ArrowDown: [0, STEP],
  };
  const press = (event: KeyboardEvent): boolean => {
    const holds = dragging.following !== null;
    if (holds && (event.key === "Escape" || event.key === "Enter")) {
      if (event.key === "Escape") dragging.cancel();
      else dragging.release();
      return true;
    }
    if (event.key === "Enter") {
      const { left, top, width, height } = canvas.getBoundingClientRect();
      if (!hold(dragging, left + width / 2, top + height / 2)) tell("The middle of the picture is not on the face.");
      return true;
    }
    const way = ways[event.key];
    if (!way || !holds) return false;
    const share = event.shiftKey ? 0.25 : 1;
    dragging.moveBy(share * way[0], share * way[1]);
    return true;
  };
  canvas.addEventListener(
    "keydown",
    (event) => {
      if (!dragging.on || dragging.loading || event.ctrlKey || event.metaKey || event.altKey || !press(event)) return;
      event.preventDefault();
      event.stopImmediatePropagation(); // arrows turn the face
    },
    { capture: true },
  );
}

/** Drags points of the picture by pointer and keys, and marks the one that is held. */
export function startDragInput(dragging: FaceDragging): void {
  const { viewer } = dragging;
  const { canvas } = viewer.stage;
  const mark = element("span", { id: "held-point", "aria-hidden": "true", hidden: true });
  canvas.after(mark);
  watchPointer(canvas, dragging);
  watchKeys(canvas, dragging);
  const show = (): void => {
    const place = dragging.place;
    mark.hidden = place === null;
    if (place) mark.style.transform = `translate(${place.x}px, ${place.y + canvas.offsetTop}px)`;
  };
  viewer.drawn.subscribe(show);
  dragging.changed.subscribe(() => {
    byId("view").classList.toggle("drags", dragging.on && !dragging.loading);
    show();
  });
}

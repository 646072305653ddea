import { MODES } from "../app/modes";
import type { Viewer } from "../app/viewer";
import { byId, element } from "./dom";

/** The radio group that chooses what is shown, where what cannot be chosen says why; and whether the true rig is. */
export function startModeBar(viewer: Viewer): void {
  const bar = byId("modes");
  const buttons = MODES.map(({ mode, label, hint }) => {
    const button = element("button", { type: "button", role: "radio", "aria-checked": "false" }, label);
    button.addEventListener("click", () => {
      viewer.mode = mode;
    });
    bar.append(button);
    return { mode, hint, button };
  });
  const trueRig = byId<HTMLButtonElement>("true-rig");
  trueRig.addEventListener("click", () => {
    viewer.trueRigBeside = !viewer.trueRigBeside;
  });
  const show = (): void => {
    for (const { mode, hint, button } of buttons) {
      const reason = viewer.whyNot(mode);
      const chosen = viewer.mode === mode;
      button.disabled = reason !== null;
      button.title = reason ?? hint;
      button.setAttribute("aria-checked", String(chosen));
      button.tabIndex = chosen ? 0 : -1;
      button.hidden = mode === "difference" && viewer.faces.length < 2;
    }
    trueRig.hidden = !viewer.truth?.known;
    trueRig.setAttribute("aria-pressed", String(viewer.trueRigBeside));
  };
  bar.addEventListener("keydown", (event) => {
    const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    const usable = buttons.filter(({ button }) => !button.disabled && !button.hidden);
    const at = usable.findIndex(({ mode }) => mode === viewer.mode);
    if (step === 0 || usable.length === 0) return;
    const next = usable[(at + step + usable.length) % usable.length];
    viewer.mode = next.mode;
    next.button.focus();
    event.preventDefault();
  });
  viewer.modeChanged.subscribe(show);
  viewer.opened.subscribe(show);
  viewer.clipsChanged.subscribe(show);
  show();
}

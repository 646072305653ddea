import type { Viewer } from "../app/viewer";
import { readPoseText, setOptions } from "../pose/pose_text";
import { element } from "./dom";
import { tell, telling } from "./messages";

/** Puts the pose of a text on the face and says what of it is not the face's. Throws as readPoseText. */
function applyText(viewer: Viewer, text: string): void {
  const { first, pose } = viewer;
  if (!first) throw new Error("Open a face first, which the values are of.");
  const { values, count, unknown } = readPoseText(text, pose, (name) => first.face.findControl(name));
  pose.assign(values);
  tell(`${count} ${count === 1 ? "control is" : "controls are"} as in the text, all others at rest.`);
  const more = unknown.length > 3 ? "; …" : "";
  if (unknown.length > 0) tell(`${unknown.length} left out: ${unknown.slice(0, 3).join("; ")}${more}.`, "error");
}

function textOf(viewer: Viewer, values: Float32Array): string {
  const text = setOptions(viewer.pose, values);
  if (text === "") throw new Error("All controls are at rest: there is nothing to copy.");
  return text;
}

const COPIED = "The values are copied, as facebaker pose takes them.";

/** Copies the values of a pose by a button. */
export function copyValues(viewer: Viewer, values: Float32Array): Promise<void> {
  return telling(async () => {
    await navigator.clipboard.writeText(textOf(viewer, values));
    tell(COPIED);
  });
}

/** Asks for a text and puts its values on the face; what is wrong with it is said beside it. */
export function askForValues(viewer: Viewer): void {
  const text = element("textarea", { id: "values", rows: 8, spellcheck: "false", placeholder: "jaw_open = 0.5\nsmile_L = 0.8" });
  const wrong = element("p", { role: "alert" });
  const apply = element("button", { type: "button", class: "primary" }, "Pose the face");
  const cancel = element("button", { type: "button" }, "Cancel");
  const dialog = element(
    "dialog",
    { "aria-labelledby": "values-title", class: "values" },
    element("h2", { id: "values-title" }, "Paste values"),
    element("label", { for: "values" }, "A line of NAME = VALUE for each control, or --set NAME=VALUE. All others go to rest."),
    text,
    wrong,
    element("div", { class: "chips" }, apply, cancel),
  );
  apply.addEventListener("click", () => {
    try {
      applyText(viewer, text.value);
      dialog.close();
    } catch (error) {
      wrong.textContent = error instanceof Error ? error.message : String(error);
    }
  });
  cancel.addEventListener("click", () => dialog.close());
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
}

/** Ctrl+C copies the pose's values where no text is selected, and Ctrl+V poses the face by a text. */
export function startPoseClipboard(viewer: Viewer, typing: (target: EventTarget | null) => boolean): void {
  const own = (event: ClipboardEvent): boolean =>
    viewer.first !== null &&
    event.clipboardData !== null &&
    !typing(event.target) &&
    document.querySelector("dialog[open]") === null;
  document.addEventListener("copy", (event) => {
    if (!own(event) || getSelection()?.isCollapsed === false) return;
    event.preventDefault();
    void telling(() => {
      event.clipboardData?.setData("text/plain", textOf(viewer, viewer.pose.values));
      tell(COPIED);
    });
  });
  document.addEventListener("paste", (event) => {
    const text = event.clipboardData?.getData("text/plain") ?? "";
    if (!own(event) || text.trim() === "") return;
    event.preventDefault();
    void telling(() => applyText(viewer, text));
  });
}

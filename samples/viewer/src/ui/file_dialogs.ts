import { openFiles } from "../app/open_files";
import type { Viewer } from "../app/viewer";
import { chosenFiles, droppedFiles } from "../clips/dropped_files";
import { byId, element } from "./dom";
import { tell } from "./messages";
import type { StartCard } from "./start_card";

const archivesOf = (files: ReadonlyMap<string, File>): string[] =>
  [...files.keys()].filter((path) => path.toLowerCase().endsWith(".fbk"));

/** Whether an archive shall stand beside the face that is there: asked where there is one. */
async function askBeside(files: ReadonlyMap<string, File>, viewer: Viewer): Promise<boolean | null> {
  const archives = archivesOf(files);
  if (archives.length !== 1 || viewer.first === null) return false;
  const dialog = element("dialog", { "aria-labelledby": "ask-title" });
  const answer = (value: string, words: string, primary = false): HTMLButtonElement => {
    const button = element("button", { type: "button", class: primary ? "primary" : undefined }, words);
    button.addEventListener("click", () => dialog.close(value));
    return button;
  };
  const title = element("h2", { id: "ask-title" }, `Where shall ${archives[0]} go?`);
  const row = element("div", { class: "chips" }, answer("instead", "In place of it", true), answer("beside", "Side by side"), answer("", "Cancel"));
  dialog.append(title, row);
  document.body.append(dialog);
  dialog.showModal();
  await new Promise((resolve) => dialog.addEventListener("close", resolve, { once: true }));
  dialog.remove();
  return dialog.returnValue === "" ? null : dialog.returnValue === "beside";
}

export interface FileDialogs {
  open(): void;
  openFolder(): void;
}

/** Opens files; what is wrong with them is told. */
async function openTold(files: ReadonlyMap<string, File>, viewer: Viewer, card: StartCard): Promise<void> {
  try {
    const beside = await askBeside(files, viewer);
    if (beside === null) return;
    for (const note of await openFiles(files, viewer, beside, (name) => card.loading(name))) tell(note);
  } catch (error) {
    const reason = error instanceof Error ? error.message : String(error);
    if (viewer.first) card.hide();
    if (viewer.first || archivesOf(files).length === 0) tell(reason, "error");
    else card.refused(reason);
  }
}

/** Files by dialog and by dropping them anywhere on the page. */
export function startFileDialogs(viewer: Viewer, card: StartCard): FileDialogs {
  const input = byId<HTMLInputElement>("files");
  const folder = element("input", { type: "file", hidden: true, webkitdirectory: true, tabindex: "-1", "aria-hidden": "true" });
  document.body.append(folder);
  const take = (files: Map<string, File>): Promise<void> => openTold(files, viewer, card);
  for (const chooser of [input, folder])
    chooser.addEventListener("change", () => {
      if (chooser.files && chooser.files.length > 0) void take(chosenFiles(chooser.files));
      chooser.value = "";
    });
  const drop = byId("drop");
  let inside = 0;
  addEventListener("dragenter", (event) => {
    event.preventDefault();
    ++inside;
    drop.hidden = false;
  });
  addEventListener("dragleave", () => {
    inside = Math.max(0, inside - 1);
    drop.hidden = inside === 0;
  });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    inside = 0;
    drop.hidden = true;
    if (event.dataTransfer) void droppedFiles(event.dataTransfer).then(take);
  });
  return { open: () => input.click(), openFolder: () => folder.click() };
}

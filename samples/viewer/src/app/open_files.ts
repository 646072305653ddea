import type { Face } from "facebaker";
import { type Clip, ClipError } from "../clips/clip";
import { readDataset } from "../clips/dataset_folder";
import { holdsKeyframes, readKeyframes } from "../clips/keyframe_file";
import { parseLiveLink } from "../clips/live_link";
import { controlsOf, parseNpy } from "../clips/npy";
import { holdsExpressions, readExpressions } from "../pose/expression_file";
import { loadFace, prepareFace } from "./open_faces";
import type { Viewer } from "./viewer";

const ending = (path: string): string => path.slice(path.lastIndexOf(".") + 1).toLowerCase();

const nextPicture = (): Promise<void> => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));

function faceFor(file: File, viewer: Viewer, what: string): Face {
  if (!viewer.first) throw new ClipError(`${file.name}: open a face first, which the ${what} of`);
  return viewer.first.face;
}

/** Takes the expressions of a table into the viewer's list; sentences for the user are added to `notes`. */
function takeExpressions(text: string, file: File, viewer: Viewer, notes: string[]): void {
  const read = readExpressions(text, file.name, faceFor(file, viewer, "expressions are").controls);
  const added = viewer.expressions.add(read.expressions);
  notes.push(`${file.name}: ${added} ${added === 1 ? "expression is" : "expressions are"} new in the list.`, ...read.notes);
}

/** Has the keyframes of a table be those of the viewer. */
function takeKeyframes(text: string, file: File, viewer: Viewer, notes: string[]): void {
  const read = readKeyframes(text, file.name, faceFor(file, viewer, "keyframes are").controls);
  viewer.keyframes.replace(read.keyframes);
  const many = read.keyframes.length === 1 ? "pose is" : "poses are";
  notes.push(`${file.name}: ${read.keyframes.length} ${many} the keyframes now.`, ...read.notes);
}

/** A clip; null for a table of expressions or keyframes, which the viewer's list has then. */
async function readClip(file: File, viewer: Viewer, notes: string[]): Promise<Clip | null> {
  if (ending(file.name) === "csv") {
    const text = await file.text();
    if (holdsKeyframes(text)) {
      takeKeyframes(text, file, viewer, notes);
      return null;
    }
    if (!holdsExpressions(text)) return parseLiveLink(text, faceFor(file, viewer, "clip is").controls, file.name);
    takeExpressions(text, file, viewer, notes);
    return null;
  }
  const face = faceFor(file, viewer, "clip is");
  const { frames, controls } = controlsOf(parseNpy(await file.arrayBuffer(), file.name), face.controlCount, file.name);
  return { name: file.name, origin: "NumPy file", fps: 30, frames, controls, notes: [] };
}

/**
 * Opens what was dropped or chosen, by path: archives, the second of which is shown beside the first; clips; a dataset
 * folder. `beside`: one archive is shown beside the one that is there, too. The first clip opened is shown. `loading`:
 * is told the name of each archive before it is loaded. Returns what there is to say about the files, a sentence each.
 */
export async function openFiles(
  files: ReadonlyMap<string, File>,
  viewer: Viewer,
  beside: boolean,
  loading: (name: string) => void,
): Promise<string[]> {
  const archives = [...files.values()].filter((file) => ending(file.name) === "fbk").slice(0, 2);
  for (const [i, file] of archives.entries()) {
    const second = i > 0 || (beside && viewer.first !== null);
    loading(file.name);
    await nextPicture(); // loading leaves no time for one
    const loaded = await loadFace(file, file.name);
    viewer.show(prepareFace(loaded, second ? viewer.first!.face : null), second);
  }
  const clips: Clip[] = [];
  const notes: string[] = [];
  if (files.has("dataset.json")) {
    if (!viewer.first) throw new ClipError("open a face first, which the dataset is of");
    clips.push(...(await readDataset(files, viewer.first.face)));
  } else {
    for (const [path, file] of files) {
      if (!["npy", "csv"].includes(ending(path)) || path.endsWith(".points.npy")) continue;
      const clip = await readClip(file, viewer, notes);
      if (clip) clips.push(clip);
    }
    if (clips.length === 0 && archives.length === 0 && notes.length === 0)
      throw new ClipError(`${[...files.keys()].slice(0, 3).join(", ") || "this"}: opened are .fbk, .npy, .csv and dataset folders`);
  }
  if (clips.length > 0) {
    viewer.addClips(clips);
    viewer.openClip(clips[0]);
  }
  return notes;
}

import { type Clip, ClipError } from "../clips/clip";
import { readDataset } from "../clips/dataset_folder";
import { parseLiveLink } from "../clips/live_link";
import { controlsOf, parseNpy } from "../clips/npy";
import { loadFace, prepareFace } from "./open_faces";
import type { Viewer } from "./viewer";

const ending = (path: string): string => path.slice(path.lastIndexOf(".") + 1).toLowerCase();

const nextPicture = (): Promise<void> => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));

async function readClip(file: File, viewer: Viewer): Promise<Clip> {
  const face = viewer.first?.face;
  if (!face) throw new ClipError(`${file.name}: open a face first, which the clip is of`);
  if (ending(file.name) === "csv") return parseLiveLink(await file.text(), face.controls, file.name);
  const { frames, controls } = controlsOf(parseNpy(await file.arrayBuffer(), file.name), face.controlCount, file.name);
  return { name: file.name, origin: "NumPy file", fps: 30, frames, controls, notes: [] };
}

/**
 * Opens what was dropped or chosen, by path: archives, the second of which is shown beside the first; clips; a dataset
 * folder. `beside`: one archive is shown beside the one that is there, too. The first clip opened is shown. `loading`:
 * is told the name of each archive before it is loaded.
 */
export async function openFiles(
  files: ReadonlyMap<string, File>,
  viewer: Viewer,
  beside: boolean,
  loading: (name: string) => void,
): Promise<void> {
  const archives = [...files.values()].filter((file) => ending(file.name) === "fbk").slice(0, 2);
  for (const [i, file] of archives.entries()) {
    const second = i > 0 || (beside && viewer.first !== null);
    loading(file.name);
    await nextPicture(); // loading leaves no time for one
    const loaded = await loadFace(await file.arrayBuffer(), file.name);
    viewer.show(prepareFace(loaded, second ? viewer.first!.face : null), second);
  }
  const clips: Clip[] = [];
  if (files.has("dataset.json")) {
    if (!viewer.first) throw new ClipError("open a face first, which the dataset is of");
    clips.push(...(await readDataset(files, viewer.first.face)));
  } else {
    for (const [path, file] of files)
      if (["npy", "csv"].includes(ending(path)) && !path.endsWith(".points.npy")) clips.push(await readClip(file, viewer));
    if (clips.length === 0 && archives.length === 0)
      throw new ClipError(`${[...files.keys()].slice(0, 3).join(", ") || "this"}: opened are .fbk, .npy, .csv and dataset folders`);
  }
  if (clips.length === 0) return;
  viewer.addClips(clips);
  viewer.openClip(clips[0]);
}

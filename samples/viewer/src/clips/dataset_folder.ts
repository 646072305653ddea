import type { Face } from "facebaker";
import { type Clip, ClipError } from "./clip";
import { controlsOf, parseNpy } from "./npy";

interface DatasetClip {
  name?: unknown;
  fps?: unknown;
  split?: unknown;
  controls?: unknown;
  points?: unknown;
}

const listOf = (value: unknown): string[] => (Array.isArray(value) ? value : [value]).filter((v) => typeof v === "string");

async function joined(files: File[], read: (file: File) => Promise<Float32Array>): Promise<Float32Array> {
  const parts: Float32Array[] = [];
  for (const file of files) parts.push(await read(file));
  const all = new Float32Array(parts.reduce((length, part) => length + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

/** Points of frames, frames x vertices x 3, from the NumPy files of a clip. */
async function readPoints(files: File[], clip: string, vertices: number, frames: number): Promise<Float32Array> {
  const points = await joined(files, async (file) => parseNpy(await file.arrayBuffer(), file.name).values);
  if (points.length !== frames * vertices * 3)
    throw new ClipError(`${clip}: has ${points.length} coordinates where ${frames} frames of this face have ${frames * vertices * 3}`);
  return points;
}

/**
 * The clips of a dataset folder (docs/datasets.md) by the files in it, with their paths below the folder. Positions in
 * NumPy files are what errors are measured against; other forms of them are left out, with a note.
 */
export async function readDataset(files: ReadonlyMap<string, File>, face: Face): Promise<Clip[]> {
  const index = files.get("dataset.json");
  if (!index) throw new ClipError("the folder has no dataset.json, and no .npy or .csv");
  let document: { controls?: { name?: string }[]; clips?: DatasetClip[] };
  try {
    document = JSON.parse(await index.text());
  } catch {
    throw new ClipError("dataset.json: this is no JSON");
  }
  const names = (document.controls ?? []).map((control) => control.name);
  const own = face.controls.map((control) => control.name);
  if (names.length !== own.length || names.some((name, i) => name !== own[i]))
    throw new ClipError(`dataset.json: its ${names.length} controls are not those of this face, which has ${own.length}`);
  const clips: Clip[] = [];
  for (const entry of document.clips ?? []) {
    const pick = (paths: string[]): File[] => paths.map((path) => files.get(path)).filter((file) => file !== undefined);
    const controlFiles = pick(listOf(entry.controls));
    if (typeof entry.name !== "string" || controlFiles.length !== listOf(entry.controls).length || controlFiles.length === 0) continue;
    const name = entry.name;
    const controls = await joined(controlFiles, async (file) =>
      controlsOf(parseNpy(await file.arrayBuffer(), file.name), own.length, file.name).controls,
    );
    const frames = controls.length / own.length;
    const pointFiles = pick(listOf(entry.points));
    const readable = pointFiles.length > 0 && pointFiles.length === listOf(entry.points).length && pointFiles.every((f) => f.name.endsWith(".npy"));
    clips.push({
      name,
      origin: `dataset, ${typeof entry.split === "string" ? entry.split : "train"}`,
      fps: typeof entry.fps === "number" && entry.fps > 0 ? entry.fps : 30,
      frames,
      controls,
      notes: readable ? [] : ["Without true positions: the folder has none for this clip as .npy."],
      reference: readable ? () => readPoints(pointFiles, name, face.vertexCount, frames) : undefined,
    });
  }
  if (clips.length === 0) throw new ClipError("dataset.json: names no clip whose files are in the folder");
  return clips;
}

import { type Face, load } from "facebaker";
import { FaceObject } from "../scene/face_object";

/** A face on the screen. */
export interface ShownFace {
  /** What it is called: the file's name. */
  name: string;
  face: Face;
  object: FaceObject;
  /** The control of the first face that each of its own follows, by name; -1: none. */
  follows: Int32Array;
  bytes: number;
  source: FaceSource;
}

/** Where an archive is read from: an address, or a file. */
export type FaceSource = string | Blob;

export type Progress = (loaded: number, total: number) => void;

/** A face that is not on the screen yet. */
export interface LoadedFace {
  name: string;
  face: Face;
  bytes: number;
  source: FaceSource;
}

/** Loads an archive; what is wrong with it is told with the file's name. */
export async function loadFace(source: FaceSource, name: string, progress?: Progress): Promise<LoadedFace> {
  let bytes = typeof source === "string" ? 0 : source.size;
  try {
    const face = await load(typeof source === "string" ? source : await source.arrayBuffer(), {
      progress: (loaded, total) => {
        bytes = loaded;
        progress?.(loaded, total);
      },
    });
    return { name, face, bytes, source };
  } catch (error) {
    const reason = error instanceof Error ? error.message : String(error);
    throw new Error(reason.includes(name) ? reason : `${name}: ${reason}`);
  }
}

/** Makes what is drawn of a face. `first`: the face whose pose it follows; null: it is the first. */
export function prepareFace({ name, face, bytes, source }: LoadedFace, first: Face | null): ShownFace {
  const names = new Map((first ?? face).controls.map((control, index) => [control.name, index]));
  const follows = Int32Array.from(face.controls, (control) => names.get(control.name) ?? -1);
  return { name, face, object: new FaceObject(face), follows, bytes, source };
}

/** The pose of the first face as controls of this one; those that the first does not have stay at rest. */
export function followedControls(shown: ShownFace, values: Float32Array): Float32Array {
  return Float32Array.from(shown.follows, (from, index) => (from >= 0 ? values[from] : shown.face.restControls[index]));
}

/** Takes a face away and frees what it takes. */
export function closeFace(shown: ShownFace): void {
  shown.object.removeFromParent();
  shown.object.dispose();
  shown.face.dispose();
}

import type { Face } from "facebaker";
import type { Clip } from "../clips/clip";
import { controlsOf, parseNpy } from "../clips/npy";
import { tokenHeaders } from "./access_token";
import type { CaptureSource } from "./capture";

/** view.json beside the page, which `facebaker view` and samples/viewer/build.sh write: what to show at the start. */
export interface ViewList {
  faces: { name: string; url: string }[];
  beside?: {
    name: string;
    live: boolean;
    clips: { name: string; kind: string; fps: number; frames: number; all_frames: number; controls: string; points: string }[];
  };
  capture?: CaptureSource;
}

export async function readViewList(): Promise<ViewList> {
  const answer = await fetch("./view.json");
  return answer.ok ? ((await answer.json()) as ViewList) : { faces: [] };
}

async function fetchArray(url: string): Promise<ArrayBuffer> {
  const answer = await fetch(`./${url}`, { headers: tokenHeaders() });
  if (!answer.ok) throw new Error((await answer.text()).trim() || `${url}: the server answers ${answer.status}`);
  return answer.arrayBuffer();
}

/** The clips of the source beside the face; their controls are read now, their positions when they are shown. */
export async function clipsBeside(list: ViewList, face: Face): Promise<Clip[]> {
  const { beside } = list;
  if (!beside) return [];
  return Promise.all(
    beside.clips.map(async (clip): Promise<Clip> => {
      const { frames, controls } = controlsOf(parseNpy(await fetchArray(clip.controls), clip.name), face.controlCount, clip.name);
      return {
        name: clip.name,
        origin: `${beside.name}, ${clip.kind}`,
        fps: clip.fps > 0 ? clip.fps : 30,
        frames,
        controls,
        notes: clip.frames < clip.all_frames ? [`The first ${clip.frames} of ${clip.all_frames} frames.`] : [],
        reference: async () => parseNpy(await fetchArray(clip.points), clip.name).values,
      };
    }),
  );
}

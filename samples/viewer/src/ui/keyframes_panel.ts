import type { Viewer } from "../app/viewer";
import { writeKeyframes } from "../clips/keyframe_file";
import { KEYFRAME_RATE, type Keyframe, MOST_FRAMES } from "../clips/keyframes";
import { writeNpy } from "../clips/npy";
import { byId, element } from "./dom";
import { download } from "./download";
import { tell, telling } from "./messages";

const HINT =
  "Controls go straight from one pose to the next, at 30 frames a second. A clip is a NumPy file of frames × controls, as " +
  "facebaker pose --clip and export --clip read it; the table (.csv) has the poses alone, to go on with here.";

const secondsOf = (frame: number): string => (frame / KEYFRAME_RATE).toFixed(2);

function makeRow(viewer: Viewer, keyframe: Keyframe, number: number): HTMLElement {
  const { keyframes, pose } = viewer;
  const { frame, values } = keyframe;
  const name = `pose ${number}`;
  const moved = values.reduce((count, value, i) => count + (value === pose.rest[i] ? 0 : 1), 0);
  const time = element("input", {
    type: "number",
    min: 0,
    max: MOST_FRAMES / KEYFRAME_RATE,
    step: "any",
    value: secondsOf(frame),
    "aria-label": `Time of ${name}, seconds`,
  });
  time.addEventListener("change", () => {
    const seconds = time.valueAsNumber;
    keyframes.move(keyframe, Number.isFinite(seconds) ? seconds * KEYFRAME_RATE : frame);
  });
  const button = (label: string, spoken: string, action: () => void, more: Record<string, string> = {}): HTMLButtonElement => {
    const made = element("button", { type: "button", "aria-label": spoken, ...more }, label);
    made.addEventListener("click", action);
    return made;
  };
  const show = element(
    "button",
    { type: "button", class: "show", title: "Pose the face so" },
    element("span", { class: "title" }, `Pose ${number}`),
    element("span", { class: "where" }, `${moved} ${moved === 1 ? "control" : "controls"}`),
  );
  show.addEventListener("click", () => pose.assign(values));
  return element(
    "li",
    {},
    time,
    element("span", { class: "where", "aria-hidden": "true" }, "s"),
    show,
    button("Set", `Set ${name} to what is shown`, () => keyframes.set(keyframe, pose.values), {
      title: "To the pose that is shown",
    }),
    button("×", `Remove ${name}`, () => keyframes.remove(keyframe), { title: "Remove", class: "plain" }),
  );
}

/** Poses over time: adding and moving them, playing them, and files of them. Returns what adds the pose that is shown. */
export function startKeyframesPanel(viewer: Viewer): () => void {
  const { keyframes } = viewer;
  const list = element("ul", { class: "expressions keyframes", "aria-label": "Keyframes" });
  const button = (label: string, action: () => void, title?: string): HTMLButtonElement => {
    const made = element("button", { type: "button", title }, label);
    made.addEventListener("click", action);
    return made;
  };
  let told: HTMLElement | null = null;
  const addPose = (): void => {
    if (!viewer.first) return;
    told?.remove();
    const { frame } = keyframes.add(viewer.pose.values);
    told = tell(`The pose is added at ${secondsOf(frame)} seconds.`);
  };
  const nameOf = (ending: string): string => `${viewer.first?.face.name || "face"}.${ending}`;
  const add = button("Add pose", addPose, "Add the pose that is shown (K)");
  const play = button("Preview", () => {
    viewer.openClip(keyframes.clip());
    viewer.player.toggle();
  });
  const saveClip = button("Save as a clip", () => {
    const clip = keyframes.clip();
    if (!clip) return;
    const bytes = writeNpy(clip.controls, [clip.frames, clip.controls.length / clip.frames]);
    download(nameOf("clip.npy"), bytes, "application/octet-stream");
  });
  const saveTable = button("Save the poses", () =>
    void telling(() => download(nameOf("keyframes.csv"), writeKeyframes(keyframes.all, viewer.pose.controls), "text/csv")),
  );
  byId("clips").append(
    element("h2", {}, "Keyframes"),
    list,
    element("div", { class: "row" }, add, play, saveClip, saveTable),
    element("p", { class: "hint" }, HINT),
  );
  const show = (): void => {
    list.replaceChildren(...keyframes.all.map((keyframe, i) => makeRow(viewer, keyframe, i + 1)));
    list.hidden = play.disabled = saveClip.disabled = saveTable.disabled = keyframes.all.length === 0;
    add.disabled = viewer.first === null;
  };
  keyframes.changed.subscribe(show);
  viewer.opened.subscribe(show);
  show();
  return addPose;
}

import { readRights, today } from "../app/face_rights";
import type { ShownFace } from "../app/open_faces";
import type { Viewer } from "../app/viewer";
import { byId, element } from "./dom";
import { bytesText, figure } from "./number_text";

const BENCHED = 64; // poses

/** Microseconds of a pose, positions alone: the median of random poses. */
function microsecondsOf({ face }: ShownFace): number {
  const poses = Array.from({ length: BENCHED }, () =>
    Float32Array.from(face.controls, ({ minimum, maximum, neutral }) =>
      Math.random() < 0.15 ? minimum + Math.random() * (maximum - minimum) : neutral,
    ),
  );
  const positions = new Float32Array(3 * face.vertexCount);
  for (const controls of poses) face.evaluate(controls, positions);
  const start = performance.now();
  for (const controls of poses) face.evaluate(controls, positions);
  return (1000 * (performance.now() - start)) / BENCHED;
}

function pretty(json: string): string {
  try {
    return JSON.stringify(JSON.parse(json), null, 1);
  } catch {
    return json;
  }
}

/** "yes" or "no", or "" where the archive does not say whether it was learned from poses. */
function learned(provenance: string): string {
  try {
    const said: unknown = JSON.parse(provenance).learned;
    return typeof said === "string" ? said : "";
  } catch {
    return "";
  }
}

function describe(shown: ShownFace): HTMLElement[] {
  const { face, name, bytes } = shown;
  const rows: [string, string][] = [
    ["File", `${name}, ${bytesText(bytes)}`],
    ["Vertices", face.vertexCount.toLocaleString("en")],
    ["Controls", String(face.controlCount)],
    ["Meshes", face.meshes.map((mesh) => mesh.name || "face").join(", ")],
    ["Diagonal D", `${figure(face.diagonal)} ${face.units}, ${face.upAxis} up`],
    ["In memory", bytesText(face.runtimeBytes)],
    ["Runs on", face.instructionSet],
  ];
  const saidLearned = learned(face.provenance);
  if (saidLearned) rows.push(["Learned", saidLearned]);
  if (face.levels.length > 1) rows.push(["Levels of detail", face.levels.map((l) => l.vertexCount).join(", ") + " vertices"]);
  if (face.sockets.length > 0) rows.push(["Sockets", face.sockets.map((socket) => socket.name).join(", ")]);
  if (face.channels.length > 0) rows.push(["Channels", face.channels.map((channel) => channel.name).join(", ")]);
  if (face.drivenJoints.length > 0) rows.push(["Driven joints", String(face.drivenJoints.length)]);
  if (face.joints.length > 0) rows.push(["Joints", String(face.joints.length)]);
  const list = element("dl");
  for (const [what, value] of rows) list.append(element("dt", {}, what), element("dd", {}, value));
  const speed = element("button", { type: "button" }, "Time 64 random poses");
  const time = element("dd");
  speed.addEventListener("click", () => {
    time.textContent = `${Math.round(microsecondsOf(shown))} µs a pose, positions alone`;
  });
  list.append(element("dt", {}, speed), time);
  const parts: HTMLElement[] = [element("h2", {}, face.name || name), list];
  const { binding } = readRights(face.about, today());
  if (binding.length > 0)
    parts.push(element("h3", {}, "What binds of its rights"), element("ul", { class: "binding" }, ...binding.map((clause) => element("li", {}, clause))));
  if (face.about) parts.push(element("h3", {}, "About the character"), element("pre", { tabindex: "0" }, pretty(face.about)));
  if (face.provenance) parts.push(element("h3", {}, "Provenance"), element("pre", { tabindex: "0" }, pretty(face.provenance)));
  return parts;
}

/** What the faces are, and taking the second one away. */
export function startAboutPanel(viewer: Viewer): void {
  const panel = byId("about");
  const show = (): void => {
    const parts = viewer.faces.flatMap(describe);
    if (viewer.faces.length > 1) {
      const remove = element("button", { type: "button" }, "Show the first face alone");
      remove.addEventListener("click", () => viewer.removeSecond());
      parts.unshift(remove);
    }
    panel.replaceChildren(...(parts.length > 0 ? parts : [element("p", { class: "none" }, "No face yet.")]));
  };
  viewer.opened.subscribe(show);
  show();
}

import type { Pose } from "./pose";

/** What a link carries besides controls: how the face is looked at. */
export interface SharedView {
  mode?: string;
  /** Position and target of the camera, in diagonals of the face. */
  camera?: number[];
}

/** The fewest digits that give the same float back. */
export function shortest(value: number): string {
  for (let digits = 1; digits < 9; ++digits) {
    const text = String(Number(value.toPrecision(digits)));
    if (Math.fround(Number(text)) === value) return text;
  }
  return String(Number(value.toPrecision(9)));
}

const escaped = (name: string): string => encodeURIComponent(name).replace(/[~()'!*]/g, (c) => `%${c.charCodeAt(0).toString(16)}`);

/** A URL's hash: the controls that are not at rest, by name, with the very floats. */
export function encodeLink(pose: Pose, view: SharedView): string {
  const parts: string[] = [];
  pose.controls.forEach((control, index) => {
    if (!pose.isAtRest(index)) parts.push(`${escaped(control.name)}~${shortest(pose.values[index])}`);
  });
  const fields: string[] = [];
  if (parts.length > 0) fields.push(`pose=${parts.join("!")}`);
  if (view.mode !== undefined && view.mode !== "shaded") fields.push(`mode=${encodeURIComponent(view.mode)}`);
  if (view.camera) fields.push(`camera=${view.camera.map((x) => Number(x.toFixed(3))).join("!")}`);
  return fields.length > 0 ? `#${fields.join("&")}` : "";
}

export interface ReadLink extends SharedView {
  values: Map<string, number>;
}

/** The reverse. Whatever is not understood is left out: links come from anywhere. */
export function decodeLink(hash: string): ReadLink {
  const link: ReadLink = { values: new Map() };
  for (const field of hash.replace(/^#/, "").split("&")) {
    const equals = field.indexOf("=");
    const [key, text] = [field.slice(0, equals), field.slice(equals + 1)];
    try {
      if (key === "mode") link.mode = decodeURIComponent(text);
      if (key === "camera") {
        const numbers = text.split("!").map(Number);
        if (numbers.length === 6 && numbers.every((x) => Math.abs(x) < 100)) link.camera = numbers;
      }
      if (key === "pose")
        for (const part of text.split("!")) {
          const [name, value] = part.split("~");
          if (value !== undefined && value !== "" && Number.isFinite(Number(value)))
            link.values.set(decodeURIComponent(name), Number(value));
        }
    } catch {
      continue; // a malformed escape
    }
  }
  return link;
}

/** Puts the controls of a link into a pose, the others to rest. Returns the names that the face does not have. */
export function applyLink(link: ReadLink, pose: Pose): string[] {
  const values = pose.rest.slice();
  const byName = new Map(pose.controls.map((control, index) => [control.name, index]));
  const unknown: string[] = [];
  for (const [name, value] of link.values) {
    const index = byName.get(name);
    if (index === undefined) unknown.push(name);
    else values[index] = value;
  }
  pose.assign(values);
  return unknown;
}

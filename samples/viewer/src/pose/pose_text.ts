import { shortest } from "./pose_link";
import type { Pose } from "./pose";

/** As the shell reads it back. */
const quoted = (word: string): string => (/^[\w.:=@%+/-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

/** The controls that are not at rest, as options of `facebaker pose`, with the very floats. */
export function setOptions(pose: Pose, values: Float32Array): string {
  return pose.controls
    .filter(({ index }) => values[index] !== pose.rest[index])
    .map(({ index, name }) => `--set ${quoted(`${name}=${shortest(values[index])}`)}`)
    .join(" ");
}

/** Words as a POSIX shell splits them: quotes and backslashes are taken away. */
function shellWords(text: string): string[] {
  const plain = (_: string, single?: string, double?: string, one?: string): string =>
    single ?? double?.replace(/\\(["\\$`])/g, "$1") ?? one ?? "";
  const words = text.replace(/\\\r?\n/g, " ").matchAll(/(?:'[^']*'|"(?:\\.|[^"\\])*"|\\.|[^\s'"\\])+/gs);
  return Array.from(words, ([word]) => word.replace(/'([^']*)'|"((?:\\.|[^"\\])*)"|\\(.)/gs, plain));
}

/** A name, its value as text, and where it stands in the text. */
type Setting = readonly [name: string, value: string, where: string];

function splitSetting(text: string, where: string): Setting {
  const [, name, value] = /^(.*\S)\s*=\s*(\S*)$/.exec(text) ?? /^(.*\S)\s*[:\t]\s*(\S+)$/.exec(text) ?? [];
  if (name === undefined || value === undefined) throw new Error(`${where}: "${text}" is not NAME = VALUE`);
  return [name, value, where];
}

function settingsOf(text: string): Setting[] {
  if (!/(^|\s)--set[\s=]/.test(text))
    return text.split(/\r?\n/).flatMap((line, i) => {
      const plain = line.trim();
      return plain === "" || plain.startsWith("#") ? [] : [splitSetting(plain, `Line ${i + 1}`)];
    });
  const words = shellWords(text);
  return words.flatMap((word, i) => {
    if (word.startsWith("--set=")) return [splitSetting(word.slice(6), "--set")];
    return word === "--set" ? [splitSetting(words[i + 1] ?? "", "--set")] : [];
  });
}

export interface ReadPose {
  values: Float32Array;
  /** How many controls the text has. */
  count: number;
  /** What is wrong with the names of others, a sentence each. */
  unknown: string[];
}

/**
 * The pose that a text has: `--set NAME=VALUE` options, as of a command, or lines of NAME = VALUE; controls that are not
 * in it are at rest. `find`: the index of a control; it throws where there is none of that name. Throws where the text
 * has something else, and where it has no control of this face.
 */
export function readPoseText(text: string, pose: Pose, find: (name: string) => number): ReadPose {
  const values = pose.rest.slice();
  const unknown: string[] = [];
  const settings = settingsOf(text);
  for (const [name, value, where] of settings) {
    const number = value === "" ? NaN : Number(value);
    if (!Number.isFinite(number)) throw new Error(`${where}: "${name}" is to be "${value}", which is no number`);
    try {
      values[find(name)] = number;
    } catch (error) {
      unknown.push(error instanceof Error ? error.message : String(error));
    }
  }
  const count = settings.length - unknown.length;
  if (settings.length === 0) throw new Error("There are no values in it: give NAME = VALUE in a line each, or --set NAME=VALUE");
  if (count === 0) throw new Error(`No value is of this face: ${unknown[0]}`);
  return { values, count, unknown };
}

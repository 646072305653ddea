import type { Control } from "facebaker";
import { readPoseTable, writePoseTable } from "../pose/pose_table";
import { ClipError } from "./clip";
import { KEYFRAME_RATE, type Keyframe, MOST_FRAMES } from "./keyframes";

/** Keyframes as comma-separated values: a column `seconds`, then the controls that are not at rest in all of them. */
export function writeKeyframes(keyframes: readonly Keyframe[], controls: readonly Control[]): string {
  const cellOf = (frame: number): string => String(Number((frame / KEYFRAME_RATE).toFixed(4)));
  return writePoseTable("seconds", keyframes.map(({ frame, values }) => ({ cell: cellOf(frame), values })), controls);
}

/** Whether a .csv holds keyframes: its first line names a column of seconds. */
export const holdsKeyframes = (text: string): boolean => /^\ufeff?[\s"]*seconds[\s"]*([,;\t\r\n]|$)/i.test(text);

export interface ReadKeyframes {
  keyframes: Keyframe[];
  /** Sentences about what is not as the file has it. */
  notes: string[];
}

/** Reads what writeKeyframes writes; messages name the file, the line and the column. */
export function readKeyframes(text: string, file: string, controls: readonly Control[]): ReadKeyframes {
  const { rows, notes } = readPoseTable(text, file, controls, "poses");
  const taken = new Set<number>();
  const keyframes = rows.map(({ cell, values }, i) => {
    const frame = cell === "" ? NaN : Math.round(Number(cell) * KEYFRAME_RATE);
    if (!(frame >= 0 && frame < MOST_FRAMES))
      throw new ClipError(`${file}, pose ${i + 1}: "${cell}" is no time from 0 to ${MOST_FRAMES / KEYFRAME_RATE} seconds`);
    if (taken.has(frame)) throw new ClipError(`${file}, pose ${i + 1}: another pose is at ${cell} seconds, too`);
    taken.add(frame);
    return { frame, values };
  });
  return { keyframes, notes };
}

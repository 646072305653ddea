import type { Control } from "facebaker";
import { ClipError } from "../clips/clip";
import { numberOf, parseCsv } from "../clips/csv";
import { matchNames } from "../clips/match_names";
import { shortest } from "./pose_link";

/** A row of a table of poses: what its first cell has, and the values of all controls. */
export interface PoseRow {
  cell: string;
  values: Float32Array;
}

export interface ReadPoseTable {
  rows: PoseRow[];
  /** Sentences about what is not as the file has it. */
  notes: string[];
}

/** Poses as comma-separated values: a column named `first`, then one for each control that is not at rest in all of them, with
 * the very floats. */
export function writePoseTable(first: string, rows: readonly PoseRow[], controls: readonly Control[]): string {
  const moved = ({ index, neutral }: Control): boolean => rows.some(({ values }) => values[index] !== Math.fround(neutral));
  const columns = controls.filter(moved);
  const broken = columns.find(({ name }) => /[",;\t\n]/.test(name));
  if (broken) throw new Error(`control "${broken.name}": a .csv cannot have a column of this name`);
  const lines = rows.map(({ cell, values }) => [cell, ...columns.map(({ index }) => shortest(values[index]))]);
  return [[first, ...columns.map(({ name }) => name)], ...lines].map((cells) => `${cells.join(",")}\n`).join("");
}

/** The control of each column, -1 where there is none. Fails where there is none at all. */
function controlsOfColumns(columns: readonly string[], controls: readonly Control[], file: string, notes: string[]): number[] {
  const found = matchNames(columns, controls.map(({ name, arkit, facs }) => [name, arkit, facs]));
  const known = found.filter((control) => control >= 0);
  const twice = known.find((control, i) => known.indexOf(control) !== i);
  if (twice !== undefined) throw new ClipError(`${file}: two columns are the control "${controls[twice].name}"`);
  const unknown = columns.filter((_, i) => found[i] < 0).map((name) => `"${name}"`);
  const named = unknown.slice(0, 5).join(", ") + (unknown.length > 5 ? ` and ${unknown.length - 5} more` : "");
  if (known.length === 0 && unknown.length > 0) throw new ClipError(`${file}: this face has no controls ${named}`);
  if (unknown.length > 0) notes.push(`${file}: this face has no controls ${named}; they are left out.`);
  return found;
}

/** Reads what writePoseTable writes, or a spreadsheet; messages name the file, the line and the column. `what`: what its rows
 * are called. */
export function readPoseTable(text: string, file: string, controls: readonly Control[], what: string): ReadPoseTable {
  const { columns, rows } = parseCsv(text, file);
  const notes: string[] = [];
  const found = controlsOfColumns(columns.slice(1), controls, file, notes);
  let outside = 0;
  const read = rows.map(({ line, cells }): PoseRow => {
    const values = Float32Array.from(controls, ({ neutral }) => neutral);
    found.forEach((control, i) => {
      if (control < 0) return;
      const { minimum, maximum } = controls[control];
      const value = numberOf(cells[i + 1], `${file}, line ${line}, column "${columns[i + 1]}"`);
      values[control] = Math.min(Math.max(value, minimum), maximum);
      if (value < minimum || value > maximum) ++outside;
    });
    return { cell: cells[0], values };
  });
  if (read.length === 0) throw new ClipError(`${file}: there are no ${what} below its first line`);
  const many = outside === 1 ? "value is" : "values are";
  if (outside > 0) notes.push(`${file}: ${outside} ${many} outside the range of the control, and clamped.`);
  return { rows: read, notes };
}

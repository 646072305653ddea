import type { Control } from "facebaker";
import { type Clip, ClipError } from "./clip";
import { type CsvTable, numberOf, parseCsv } from "./csv";
import { matchNames } from "./match_names";

/** Frames of timecodes a second that are in use. */
const RATES = [24, 25, 30, 48, 50, 60, 100, 120, 240];
const LONGEST_TAKE = 2 ** 26; // values of all frames

interface Timecode {
  seconds: number;
  frames: number;
}

interface Columns {
  timecode: number;
  /** Of coefficients, 0 in rows without a face; -1: no such column. */
  count: number;
  /** The control of each column, or -1. */
  controls: number[];
}

function matchColumns(table: CsvTable, controls: readonly Control[], name: string, notes: string[]): Columns {
  const [timecode, count] = matchNames(["Timecode", "BlendshapeCount"], table.columns.map((column) => [column]));
  if (timecode < 0) throw new ClipError(`${name} is no recording of Live Link Face: its first line names no column "Timecode"`);
  const found = matchNames(table.columns, controls.map((control) => [control.arkit ?? "", control.name]));
  found[timecode] = -1;
  if (count >= 0) found[count] = -1;
  const driven = new Set<number>();
  const unknown: string[] = [];
  found.forEach((control, column) => {
    if (column === timecode || column === count) return;
    if (control < 0) unknown.push(table.columns[column]);
    else if (driven.has(control)) throw new ClipError(`${name}: two columns are the control "${controls[control].name}"`);
    else driven.add(control);
  });
  if (driven.size === 0)
    throw new ClipError(`${name}: no control of this face has the ARKit name of a column, such as "jawOpen"`);
  if (unknown.length > 0) notes.push(`No controls have the names ${unknown.join(", ")}.`);
  if (driven.size < controls.length)
    notes.push(`${controls.length - driven.size} of ${controls.length} controls have no column and stay at rest.`);
  return { timecode, count, controls: found };
}

function parseTimecode(text: string, where: string): Timecode {
  const match = /^(\d{1,2}):(\d{1,2}):(\d{1,2})[:;](\d+(?:\.\d*)?)$/.exec(text);
  const [hours, minutes, seconds, frames] = (match ?? []).slice(1).map(Number);
  if (!match || hours > 23 || minutes > 59 || seconds > 59 || frames >= 1000)
    throw new ClipError(`${where}: the timecode "${text}" is not hours:minutes:seconds:frames`);
  return { seconds: 60 * (60 * hours + minutes) + seconds, frames };
}

/** Appends a timecode; false, and nothing, if it is that before. Recordings may go on through midnight. */
function addTimecode(timecodes: Timecode[], timecode: Timecode, where: string): boolean {
  const before = timecodes.at(-1);
  if (before) {
    while (timecode.seconds < before.seconds - 43200) timecode.seconds += 86400;
    if (timecode.seconds === before.seconds && timecode.frames === before.frames) return false;
    if (timecode.seconds < before.seconds || (timecode.seconds === before.seconds && timecode.frames < before.frames))
      throw new ClipError(`${where}: the timecode is earlier than that before`);
  }
  timecodes.push(timecode);
  return true;
}

/** The largest frame number seen, rounded up to a rate in use. Recordings within a second do not show it. */
function timecodeRate(timecodes: readonly Timecode[], notes: string[]): number {
  const largest = Math.max(0, ...timecodes.map((timecode) => Math.floor(timecode.frames) + 1));
  if (timecodes[0].seconds === timecodes[timecodes.length - 1].seconds) {
    if (timecodes.length > 1) notes.push("Within a second; 60 frames of timecodes are taken to be one.");
    return Math.max(largest, 60);
  }
  return RATES.find((rate) => largest <= rate) ?? largest;
}

/** The rate that most rows have, in whole frames a second. */
function rateOf(times: readonly number[]): number {
  const steps = times.slice(1).map((time, row) => time - times[row]).sort((a, b) => a - b);
  if (steps.length === 0) return 60;
  return Math.min(Math.max(Math.round(1 / steps[Math.floor(steps.length / 2)]), 1), 1000);
}

/** Evenly spaced frames, interpolated linearly between rows. */
function resample(times: readonly number[], rows: readonly Float32Array[], fps: number, name: string): Float32Array {
  const width = rows[0].length;
  const frames = Math.floor(times[times.length - 1] * fps + 1e-3) + 1;
  if (frames * width > LONGEST_TAKE) throw new ClipError(`${name}: ${frames} frames are too many`);
  const values = new Float32Array(frames * width);
  for (let frame = 0, row = 0; frame < frames; ++frame) {
    const time = frame / fps;
    while (row + 1 < times.length && times[row + 1] <= time + 1e-3 / fps) ++row;
    const next = Math.min(row + 1, times.length - 1);
    const past = time - times[row];
    const part = next === row || past * fps < 1e-3 ? 0 : past / (times[next] - times[row]);
    for (let c = 0; c < width; ++c)
      values[frame * width + c] = rows[row][c] + part * (rows[next][c] - rows[row][c]);
  }
  return values;
}

/**
 * A recording of Live Link Face, a row a frame and a column for each of ARKit's face blendshapes, as a clip of a face:
 * read like `facebaker pose --livelink`. Columns are matched to ARKit names of controls, or else to their own. A
 * coefficient is the value of its control or, if the control has a unit, the part of the way from rest to the upper end.
 */
export function parseLiveLink(text: string, controls: readonly Control[], name: string): Clip {
  const notes: string[] = [];
  const table = parseCsv(text, name);
  const columns = matchColumns(table, controls, name, notes);
  const timecodes: Timecode[] = [];
  const rows: Float32Array[] = [];
  let leftOut = 0;
  for (const { line, cells } of table.rows) {
    const where = `${name}, line ${line}`;
    const face = columns.count < 0 || numberOf(cells[columns.count], where) > 0;
    if (!face || !addTimecode(timecodes, parseTimecode(cells[columns.timecode], where), where)) {
      ++leftOut;
      continue;
    }
    const row = Float32Array.from(controls, (control) => control.neutral);
    columns.controls.forEach((index, column) => {
      if (index < 0) return;
      const control = controls[index];
      const value = numberOf(cells[column], `${where}, column "${table.columns[column]}"`);
      row[index] = control.unit ? control.neutral + value * (control.maximum - control.neutral) : value;
    });
    rows.push(row);
  }
  if (timecodes.length === 0) throw new ClipError(`${name}: there are no frames of a face`);
  if (leftOut > 0) notes.push(`${leftOut} rows without a face or a timecode of their own are left out.`);
  const rate = timecodeRate(timecodes, notes);
  const times = timecodes.map((t) => t.seconds - timecodes[0].seconds + (t.frames - timecodes[0].frames) / rate);
  const fps = rateOf(times);
  const values = resample(times, rows, fps, name);
  return { name, origin: "Live Link Face", fps, frames: values.length / controls.length, controls: values, notes };
}

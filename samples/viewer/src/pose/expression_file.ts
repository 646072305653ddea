import type { Control } from "facebaker";
import type { Expression } from "./expressions";
import { readPoseTable, writePoseTable } from "./pose_table";

/**
 * Expressions as a table of comma-separated values, which `facebaker bake --exact` and `--poses-like` read as well: a
 * column of names, then the controls.
 */
export function writeExpressions(expressions: readonly Expression[], controls: readonly Control[]): string {
  return writePoseTable("expression", expressions.map(({ name, values }) => ({ cell: name, values })), controls);
}

/** Whether a .csv holds expressions: its first line names a column of names. */
export const holdsExpressions = (text: string): boolean => /^\ufeff?[\s"]*expression[\s"]*([,;\t\r\n]|$)/i.test(text);

export interface ReadExpressions {
  expressions: Expression[];
  /** Sentences about what is not as the file has it. */
  notes: string[];
}

/** Reads what writeExpressions writes, or a spreadsheet; messages name the file, the line and the column. */
export function readExpressions(text: string, file: string, controls: readonly Control[]): ReadExpressions {
  const { rows, notes } = readPoseTable(text, file, controls, "expressions");
  return { expressions: rows.map(({ cell, values }) => ({ name: cell, values })), notes };
}

import { ClipError } from "./clip";

/** Separated values whose first line names the columns. */
export interface CsvTable {
  columns: string[];
  rows: { line: number; cells: string[] }[];
}

const cellsOf = (line: string, separator: string): string[] =>
  line.split(separator).map((cell) => cell.replace(/^[\s"]+|[\s"]+$/g, ""));

/** That of the first line: which it has most of. Spreadsheets write others than the comma where that is the decimal one. */
function separatorOf(line: string): string {
  const counts = [",", ";", "\t"].map((separator) => ({ separator, count: line.split(separator).length }));
  return counts.reduce((best, other) => (other.count > best.count ? other : best)).separator;
}

/** Quotes and blanks around cells, a byte order mark, line ends of Windows and empty lines are left out. */
export function parseCsv(text: string, name: string): CsvTable {
  const [first, ...rest] = text.replace(/^\ufeff/, "").split("\n");
  const separator = separatorOf(first);
  const columns = cellsOf(first, separator);
  const rows: CsvTable["rows"] = [];
  rest.forEach((text, index) => {
    const cells = cellsOf(separator === "," ? text : text.replaceAll(",", "."), separator);
    if (cells.length === 1 && cells[0] === "") return;
    if (cells.length !== columns.length)
      throw new ClipError(`${name}, line ${index + 2}: ${cells.length} cells where the first line names ${columns.length}`);
    rows.push({ line: index + 2, cells });
  });
  return { columns, rows };
}

/** The number in a cell; `where` names it in messages. */
export function numberOf(text: string, where: string): number {
  const value = text === "" ? NaN : Number(text);
  if (!Number.isFinite(value)) throw new ClipError(`${where}: "${text}" is no number`);
  return value;
}

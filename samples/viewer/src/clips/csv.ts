import { ClipError } from "./clip";

/** Comma-separated values whose first line names the columns. */
export interface CsvTable {
  columns: string[];
  rows: { line: number; cells: string[] }[];
}

const cellsOf = (line: string): string[] => line.split(",").map((cell) => cell.replace(/^[\s"]+|[\s"]+$/g, ""));

/** Quotes and blanks around cells, a byte order mark, line ends of Windows and empty lines are left out. */
export function parseCsv(text: string, name: string): CsvTable {
  const [first, ...rest] = text.replace(/^\ufeff/, "").split("\n");
  const columns = cellsOf(first);
  const rows: CsvTable["rows"] = [];
  rest.forEach((text, index) => {
    const cells = cellsOf(text);
    if (cells.length === 1 && cells[0] === "") return;
    if (cells.length !== columns.length)
      throw new ClipError(`${name}, line ${index + 2}: ${cells.length} cells where the first line names ${columns.length}`);
    rows.push({ line: index + 2, cells });
  });
  return { columns, rows };
}

// Writes the examples of docs/web-engines.md, the first block of code of each section, as modules.
//   docs_examples.js DOCS_PAGE FOLDER
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";

/** Lines that are not empty which an example may have. */
const mostLines = 15;

const [page, folder] = process.argv.slice(2) as [string, string];
mkdirSync(folder, { recursive: true });
for (const section of readFileSync(page, "utf8").split(/^## /m).slice(1)) {
  const found = /^```(jsx?)\n([^]*?)^```/m.exec(section);
  if (!found) continue;
  const heading = section.slice(0, section.indexOf("\n")), [, language, code] = found as unknown as [string, string, string];
  const lines = code.split("\n").filter((line) => line.trim() !== "").length;
  if (lines > mostLines) throw new Error(`${page}: the example "${heading}" has ${lines} lines, above ${mostLines}`);
  writeFileSync(`${folder}/${heading.toLowerCase().replace(/[^a-z]+/g, "_")}.${language}`, code);
  console.log(`${heading}: ${lines} lines`);
}

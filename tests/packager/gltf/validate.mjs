// Validates glTF files by Khronos' validator; fails on an error in one of them. Warnings are printed.
//   node validate.mjs FILE.glb...
import fs from "node:fs";
import validator from "gltf-validator";

let errors = 0;
for (const file of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 1000 });
  console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
  const found = new Map();
  for (const { severity, code, message, pointer } of issues.messages)
    if (severity < 2 && !found.has(code)) found.set(code, `  ${["error", "warning"][severity]} at ${pointer}: ${message}`);
  for (const line of found.values()) console.log(line);
  errors += issues.numErrors;
}
process.exit(errors ? 1 : 0);

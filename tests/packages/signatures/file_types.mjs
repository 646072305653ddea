// The media type that npm's file-type finds in each file, a line each.
import { fileTypeFromFile } from 'file-type';

for (const path of process.argv.slice(2)) console.log((await fileTypeFromFile(path))?.mime ?? 'unknown');

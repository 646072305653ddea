const utf8 = new TextEncoder();
const lowerBytes = (text: string) => utf8.encode(text.replace(/[A-Z]/g, (letter) => letter.toLowerCase()));

/** The name with the smallest edit distance to a misspelt one, for messages; "" if there are no names. As the library
 * does it: bytes of UTF-8, case-insensitive in ASCII, the first of several that are equally close. */
export function closestName(misspelt: string, names: Iterable<string>): string {
  const wanted = lowerBytes(misspelt), row = new Uint32Array(wanted.length + 1);
  let best = "", fewest = Infinity;
  for (const name of names) {
    for (let j = 0; j < row.length; ++j) row[j] = j;
    for (const letter of lowerBytes(name)) {
      let diagonal = row[0]!++;
      for (let j = 0; j < wanted.length; ++j) {
        const replaced = diagonal + Number(letter !== wanted[j]);
        diagonal = row[j + 1]!;
        row[j + 1] = Math.min(replaced, row[j]! + 1, diagonal + 1);
      }
    }
    if (row[wanted.length]! < fewest) {
      fewest = row[wanted.length]!;
      best = name;
    }
  }
  return best;
}

// The digits of the basis in as few bits as they need, for shaders that unpack them (digit_sums_shader.ts).
//
// Row blocks are cut into panels of 192 rows, and these into triples of rows, which are the axes of a vertex where row
// blocks begin with vertices. Sixteen triples are a group: of a column, the sixteen digits of one axis of a group take
// 0, 2, 4 or 8 bits each, which fills 0, 1, 2 or 4 words. Four columns, a quad, share a header.
import type { RowBlock } from "./row_blocks.js";

export const panelRows = 192;
const tripleRows = 3, groupTriples = 16, groupRows = tripleRows * groupTriples, columnsOfQuad = 4;

/** Words of the header of a quad: where the words of its first column begin; then of each column the widths of its
 * digits, as 0 to 3 in two bits for each axis of each group, and in the upper 8 bits how far behind the first one's its
 * words begin. */
export const quadWords = 1 + columnsOfQuad;

export interface Panel {
  /** Rows of the basis. */
  readonly firstRow: number;
  readonly rowCount: number;
  /** Its row block. */
  readonly block: number;
  /** The word of its first header. */
  readonly headers: number;
}

export interface PackedDigits {
  readonly panels: readonly Panel[];
  /** Headers, panel after panel, then the digits. */
  readonly words: Uint32Array;
}

export const quadCount = ({ columns }: RowBlock): number => Math.ceil(columns.length / columnsOfQuad);

function* panelsOf(blocks: readonly RowBlock[]): Generator<Panel> {
  let headers = 0;
  for (const [block, { firstRow, rowCount }] of blocks.entries())
    for (let first = 0; first < rowCount; first += panelRows) {
      yield { firstRow: firstRow + first, rowCount: Math.min(panelRows, rowCount - first), block, headers };
      headers += quadWords * quadCount(blocks[block]!);
    }
}

// Words that grow.
class WordList {
  length = 0;
  words = new Uint32Array(1024);

  push(word: number): void {
    if (this.length === this.words.length) {
      const longer = new Uint32Array(2 * this.length);
      longer.set(this.words);
      this.words = longer;
    }
    this.words[this.length++] = word;
  }
}

// 0 to 3: how many bits digits first, first + 3, ... of a group need.
function widthOf(digits: Int8Array, first: number): number {
  let least = 0, most = 0;
  for (let at = first, end = Math.min(first + groupRows, digits.length); at < end; at += tripleRows) {
    const digit = digits[at]!;
    if (digit < least) least = digit;
    if (digit > most) most = digit;
  }
  const size = Math.max(most, -1 - least);
  return least === 0 && most === 0 ? 0 : size < 2 ? 1 : size < 8 ? 2 : 3;
}

/** Appends the digits of a column of a panel; returns the widths of its header. */
function packColumn(digits: Int8Array, words: WordList): number {
  let widths = 0;
  for (let group = 0, first = 0; first < digits.length; ++group, first += groupRows)
    for (let axis = 0; axis < tripleRows; ++axis) {
      const width = widthOf(digits, first + axis), bits = (1 << width) & ~1, mask = (1 << bits) - 1;
      widths |= width << (2 * (tripleRows * group + axis));
      if (width === 0) continue;
      let word = 0, at = first + axis;
      for (let shift = 0, triple = 0; triple < groupTriples; ++triple, at += tripleRows) {
        if (at < digits.length) word |= (digits[at]! & mask) << shift;
        if ((shift += bits) < 32) continue;
        words.push(word);
        word = shift = 0;
      }
    }
  return widths;
}

export function packDigits(blocks: readonly RowBlock[]): PackedDigits {
  const panels = [...panelsOf(blocks)], digits = new WordList();
  const headers = new Uint32Array(panels.reduce((sum, { block }) => sum + quadWords * quadCount(blocks[block]!), 0));
  for (const panel of panels) {
    const block = blocks[panel.block]!, first = panel.firstRow - block.firstRow;
    for (let column = 0; column < block.columns.length; ++column) {
      const within = column % columnsOfQuad, header = panel.headers + quadWords * Math.floor(column / columnsOfQuad);
      if (within === 0) headers[header] = headers.length + digits.length;
      const behind = headers.length + digits.length - headers[header]!, begin = column * block.rowCount + first;
      headers[header + 1 + within] =
        packColumn(block.digits.subarray(begin, begin + panel.rowCount), digits) | (behind << 24);
    }
  }
  const words = new Uint32Array(headers.length + digits.length);
  words.set(headers);
  words.set(digits.words.subarray(0, digits.length), headers.length);
  return { panels, words };
}

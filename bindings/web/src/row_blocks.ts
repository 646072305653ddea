import type { Heap } from "./heap.js";

/** Consecutive rows of the basis that use the same coefficients. Row 3 i + axis is coordinate `axis` of vertex i in
 * baked order (`vertexOrder`). Its displacement is the sum over the columns c of
 * coefficients[columns[c]] * scales[c] * digits[c * rowCount + row], before driven joints move the vertex. */
export interface RowBlock {
  readonly firstRow: number;
  readonly rowCount: number;
  /** Indices of coefficients; one that is stored more finely comes twice. */
  readonly columns: Uint32Array;
  /** One a column. */
  readonly scales: Float32Array;
  /** Column after column, rowCount each. */
  readonly digits: Int8Array;
}

export function readRowBlocks(heap: Heap, model: number): RowBlock[] {
  const blocks: RowBlock[] = [];
  const count = heap.call("fb_row_block_count", model);
  for (let index = 0; index < count; ++index) {
    const block = heap.fill("fb_row_block", (to) => heap.check("fb_row_block_at", model, index, to));
    const columns: number = block.digit_column_count, rows: number = block.row_count;
    const address = heap.allocate(8 * columns + columns * rows);
    try {
      heap.check("fb_row_block_digits", model, index, address, address + 4 * columns, address + 8 * columns);
      blocks.push({
        firstRow: block.first_row, rowCount: rows, columns: heap.copyU32(address, columns),
        scales: heap.copyF32(address + 4 * columns, columns),
        digits: new Int8Array(heap.copyU8(address + 8 * columns, columns * rows).buffer),
      });
    } finally {
      heap.release(address);
    }
  }
  return blocks;
}

/** By exact pose and row block, `rowCounts` of which are given. */
export function readExactCorrections(heap: Heap, model: number, rowCounts: readonly number[]): (Float32Array | null)[][] {
  const count = heap.call("fb_exact_pose_count", model);
  const address = heap.allocate(4 + 4 * rowCounts.reduce((most, rows) => Math.max(most, rows), 0));
  try {
    return Array.from({ length: count }, (_, exact) => rowCounts.map((rows, block) => {
      heap.check("fb_exact_corrections", model, exact, block, address + 4, address);
      return heap.u32[address >>> 2] ? heap.copyF32(address + 4, rows) : null;
    }));
  } finally {
    heap.release(address);
  }
}

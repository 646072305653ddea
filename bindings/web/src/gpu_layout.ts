// The basis, the polygons around vertices and the skin of driven joints as textures of one width, for any GPU
// interface.
import type { FaceContents } from "./contents.js";
import type { RowBlock } from "./row_blocks.js";

/** Texels a row of every texture: what every WebGL 2 has. */
export const textureWidth = 2048;

const texels = (count: number): number => Math.max(1, Math.ceil(count / textureWidth)) * textureWidth;

export interface GpuBasis {
  /** Four a texel: x, y and z of a vertex in a column, and 0. Block after block, column after column, vertex after
   * vertex in baked order. */
  readonly digits: Int8Array;
  /** Four a texel, by vertex in the source's order: its first texel in `digits`, the texels from there to the next
   * column, the first of its weights, the number of columns. */
  readonly blockOfVertex: Uint32Array;
  /** Four a texel, by vertex: its rest position. */
  readonly rest: Float32Array;
  /** The coefficient of each weight, and what it is multiplied with. */
  readonly columns: Uint32Array;
  readonly scales: Float32Array;
  /** Room for the weights of a pose. */
  readonly weights: Float32Array;
}

export function layOutBasis(face: Pick<FaceContents, "vertexCount" | "vertexOrder" | "restPositions"> &
                                  { readonly rowBlocks: readonly RowBlock[] }): GpuBasis {
  const blocks = face.rowBlocks;
  const sum = (of: (block: RowBlock) => number) => blocks.reduce((total, block) => total + of(block), 0);
  for (const { firstRow, rowCount } of blocks)
    if (firstRow % 3 !== 0 || rowCount % 3 !== 0) throw new Error("a row block has parts of vertices");
  const columnCount = sum(({ columns }) => columns.length);
  const digits = new Int8Array(4 * texels(sum(({ columns, rowCount }) => (columns.length * rowCount) / 3)));
  const blockOfVertex = new Uint32Array(4 * texels(face.vertexCount)), rest = new Float32Array(4 * texels(face.vertexCount));
  const columns = new Uint32Array(columnCount), scales = new Float32Array(columnCount);
  let texel = 0, weight = 0;
  for (const block of blocks) {
    const vertices = block.rowCount / 3;
    columns.set(block.columns, weight);
    scales.set(block.scales, weight);
    for (let v = 0; v < vertices; ++v) {
      const baked = block.firstRow / 3 + v, source = face.vertexOrder ? face.vertexOrder[baked]! : baked;
      blockOfVertex.set([texel + v, vertices, weight, block.columns.length], 4 * source);
    }
    for (let c = 0; c < block.columns.length; ++c)
      for (let r = 0; r < block.rowCount; ++r)
        digits[4 * (texel + c * vertices + Math.floor(r / 3)) + (r % 3)] = block.digits[c * block.rowCount + r]!;
    texel += vertices * block.columns.length;
    weight += block.columns.length;
  }
  for (let i = 0; i < 3 * face.vertexCount; ++i) rest[4 * Math.floor(i / 3) + (i % 3)] = face.restPositions[i]!;
  return { digits, blockOfVertex, rest, columns, scales, weights: new Float32Array(texels(columnCount)) };
}

export interface GpuSkin {
  /** Of a vertex, in `influences`. */
  readonly influenceCount: number;
  /** Two a texel, by vertex in the source's order: a driven joint and its weight; those of weight 0 come last. */
  readonly influences: Float32Array;
  /** Room for what each driven joint of a pose does, less the identity: the upper three rows of a 4 x 4 matrix, a texel
   * a row. */
  readonly matrices: Float32Array;
}

/** Null of a face without driven joints. */
export function layOutSkin(face: Pick<FaceContents, "drivenJoints" | "drivenSkin">): GpuSkin | null {
  if (!face.drivenSkin) return null;
  const { influences: influenceCount, joints, weights } = face.drivenSkin;
  const influences = new Float32Array(2 * texels(joints.length));
  joints.forEach((joint, i) => influences.set([joint, weights[i]!], 2 * i));
  return { influenceCount, influences, matrices: new Float32Array(4 * texels(3 * face.drivenJoints.length)) };
}

export interface GpuCorners {
  /** Two a texel, by vertex: where its entries begin in `polygons`, and how many there are. */
  readonly around: Uint32Array;
  /** Two vertices a texel. An entry is two texels, a, b and c, d: the polygon adds (a - b) x (c - d) to the normal of
   * the vertex, twice its area vector. */
  readonly polygons: Uint32Array;
}

/** Area vectors as the library has them: of a quad by its diagonals, of other polygons as the sum of triangles of a fan,
 * each of which is an entry. */
export function layOutCorners(face: Pick<FaceContents, "vertexCount" | "meshes">): GpuCorners {
  const of: number[][] = Array.from({ length: face.vertexCount }, () => []);
  for (const { polygonSizes, polygonCorners } of face.meshes) {
    let first = 0;
    for (const size of polygonSizes) {
      const corners = Array.from(polygonCorners.subarray(first, first + size));
      const a = corners[0]!, entries: number[] = [];
      if (size === 4) entries.push(corners[2]!, a, corners[3]!, corners[1]!);
      else
        for (let k = 1; k + 1 < size; ++k) entries.push(corners[k]!, a, corners[k + 1]!, a);
      for (const vertex of new Set(corners)) of[vertex]!.push(...entries);
      first += size;
    }
  }
  const count = of.reduce((total, entries) => total + entries.length / 2, 0);
  const around = new Uint32Array(2 * texels(face.vertexCount)), polygons = new Uint32Array(2 * texels(count));
  let at = 0;
  of.forEach((entries, vertex) => {
    around.set([at, entries.length / 4], 2 * vertex);
    polygons.set(entries, 2 * at);
    at += entries.length / 2;
  });
  return { around, polygons };
}

/** Meshes as graphics interfaces draw them: triangles over vertices that have one pair of texture coordinates each. Needs
 * no engine. */
import type { FaceContents, Mesh } from "./contents.js";

/** Consecutive indices of one material. */
export interface RenderGroup {
  /** Index of its first index. */
  readonly start: number;
  /** Of indices. */
  readonly count: number;
  /** Index of a material, or -1. */
  readonly material: number;
}

/** A mesh to draw. Its first vertices are those of the mesh, in order; copies follow, of vertices on seams, which have
 * several pairs of texture coordinates. */
export interface RenderMesh {
  readonly vertexCount: number;
  /** The vertex of the face that each vertex is. */
  readonly source: Uint32Array;
  /** The vertices of the mesh, which come first, without the copies. */
  readonly ownCount: number;
  /** u and v of each vertex, v pointing up; null without texture coordinates. */
  readonly uvs: Float32Array | null;
  /** Three a triangle. */
  readonly indices: Uint32Array;
  readonly groups: readonly RenderGroup[];
}

// Finds the vertex that has a pair of texture coordinates, and makes copies for further pairs.
class SeamSplitter {
  readonly source: number[] = [];
  private readonly pair: number[] = []; // of each vertex; -1: not yet known
  private readonly next: number[] = []; // copy of the same vertex; -1: none

  constructor(private readonly mesh: Mesh) {
    for (let v = 0; v < mesh.vertexCount; ++v) this.add(v, -1);
  }

  private add(own: number, pair: number): number {
    this.source.push(this.mesh.firstVertex + own);
    this.pair.push(pair);
    this.next.push(-1);
    return this.source.length - 1;
  }

  vertexOf(corner: number): number {
    const own = this.mesh.polygonCorners[corner]! - this.mesh.firstVertex;
    if (!this.mesh.uvCorners) return own;
    const pair = this.mesh.uvCorners[corner]!;
    for (let v = own; ; v = this.next[v]!) {
      if (this.pair[v] === -1) this.pair[v] = pair;
      if (this.pair[v] === pair) return v;
      if (this.next[v] === -1) return (this.next[v] = this.add(own, pair));
    }
  }

  uvs(pairs: Float32Array): Float32Array {
    const uvs = new Float32Array(2 * this.source.length);
    this.pair.forEach((pair, v) => {
      if (pair >= 0) uvs.set(pairs.subarray(2 * pair, 2 * pair + 2), 2 * v);
    });
    return uvs;
  }
}

/** A mesh of `face.meshes`, or of one of its levels, as triangles. `uvs` are those of the face. */
export function renderMesh(mesh: Mesh, uvs: Float32Array | null): RenderMesh {
  const splitter = new SeamSplitter(mesh);
  const vertices = Uint32Array.from(mesh.polygonCorners, (_, corner) => splitter.vertexOf(corner));
  const indices = new Uint32Array(3 * (vertices.length - 2 * mesh.polygonSizes.length));
  const groups: RenderGroup[] = [];
  let corner = 0, at = 0, polygon = 0;
  for (const run of mesh.runs.length > 0 ? mesh.runs : [{ polygonCount: mesh.polygonSizes.length, material: -1 }]) {
    const start = at;
    for (let end = polygon + run.polygonCount; polygon < end; ++polygon) {
      const size = mesh.polygonSizes[polygon]!;
      for (let k = 1; k + 1 < size; ++k) {
        indices[at++] = vertices[corner]!;
        indices[at++] = vertices[corner + k]!;
        indices[at++] = vertices[corner + k + 1]!;
      }
      corner += size;
    }
    if (at > start) groups.push({ start, count: at - start, material: run.material });
  }
  return {
    vertexCount: splitter.source.length, source: Uint32Array.from(splitter.source), ownCount: mesh.vertexCount,
    uvs: mesh.uvCorners && uvs ? splitter.uvs(uvs) : null, indices, groups,
  };
}

/** All meshes of a face, or of one of its levels of detail, as triangles. */
export function renderMeshes(face: Pick<FaceContents, "meshes" | "uvs">, meshes = face.meshes): RenderMesh[] {
  return meshes.map((mesh) => renderMesh(mesh, face.uvs));
}

/** Copies what is there for each vertex of the face, three numbers, to each vertex of the mesh: positions, normals or
 * tangents. Allocates nothing. */
export function scatter(mesh: RenderMesh, values: Float32Array, to: Float32Array): void {
  const { source, vertexCount, ownCount } = mesh;
  const first = 3 * (source[0] ?? 0);
  for (let i = 0; i < 3 * ownCount; ++i) to[i] = values[first + i]!;
  for (let v = ownCount; v < vertexCount; ++v) {
    const from = 3 * source[v]!, at = 3 * v;
    to[at] = values[from]!;
    to[at + 1] = values[from + 1]!;
    to[at + 2] = values[from + 2]!;
  }
}

import type { Face } from "facebaker";
import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  DynamicDrawUsage,
  Group,
  LineBasicMaterial,
  LineSegments,
  type Material,
  Mesh,
  MeshBasicMaterial,
  MeshNormalMaterial,
  MeshStandardMaterial,
} from "three";

export type AnalysisLook = "wireframe" | "normals" | "colours";

/** Each edge of the polygons once, as pairs of vertices. */
function edgesOf(face: Face): Uint32Array {
  const seen = new Set<number>();
  const edges: number[] = [];
  for (const mesh of face.meshes) {
    let first = 0;
    for (const size of mesh.polygonSizes) {
      for (let k = 0; k < size; ++k) {
        const a = mesh.polygonCorners[first + k];
        const b = mesh.polygonCorners[first + ((k + 1) % size)];
        const key = Math.min(a, b) * face.vertexCount + Math.max(a, b);
        if (seen.has(key)) continue;
        seen.add(key);
        edges.push(a, b);
      }
      first += size;
    }
  }
  return Uint32Array.from(edges);
}

/** All triangles of a face, one mesh after another. */
function trianglesOf(face: Face): Uint32Array {
  const all = new Uint32Array(face.meshes.reduce((count, mesh) => count + mesh.triangles.length, 0));
  let at = 0;
  for (const mesh of face.meshes) {
    all.set(mesh.triangles, at);
    at += mesh.triangles.length;
  }
  return all;
}

/**
 * The face as its vertices are in the archive, one after another, so that values of vertices can be shown as colours.
 * Positions and normals are written by the runtime right into what is drawn.
 */
export class AnalysisMesh extends Group {
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  /** Linear RGB of each vertex, for the look "colours"; touch() after writing. */
  readonly colours: Float32Array;
  readonly #face: Face;
  readonly #attributes: BufferAttribute[];
  readonly #geometry = new BufferGeometry();
  readonly #surface: Mesh;
  readonly #lines: LineSegments;
  readonly #materials: Record<AnalysisLook, Material>;

  constructor(face: Face) {
    super();
    this.#face = face;
    const numbers = 3 * face.vertexCount;
    this.positions = face.restPositions.slice();
    this.normals = new Float32Array(numbers);
    this.colours = new Float32Array(numbers).fill(0.8);
    this.#attributes = [this.positions, this.normals, this.colours].map((values) =>
      new BufferAttribute(values, 3).setUsage(DynamicDrawUsage),
    );
    ["position", "normal", "color"].forEach((name, i) => this.#geometry.setAttribute(name, this.#attributes[i]));
    this.#geometry.setIndex(new BufferAttribute(trianglesOf(face), 1));
    const lineGeometry = new BufferGeometry();
    lineGeometry.setAttribute("position", this.#attributes[0]);
    lineGeometry.setIndex(new BufferAttribute(edgesOf(face), 1));
    this.#materials = {
      wireframe: new MeshBasicMaterial({ color: 0x20242b, polygonOffset: true, polygonOffsetFactor: 1.5, polygonOffsetUnits: 1 }),
      normals: new MeshNormalMaterial({ side: DoubleSide }),
      colours: new MeshStandardMaterial({ vertexColors: true, roughness: 0.85, side: DoubleSide }),
    };
    this.#surface = new Mesh(this.#geometry, this.#materials.colours);
    this.#lines = new LineSegments(lineGeometry, new LineBasicMaterial({ color: 0xf0b48f }));
    this.add(this.#surface, this.#lines);
    for (const object of this.children) object.frustumCulled = false; // its bounds change with every pose
  }

  set look(look: AnalysisLook) {
    this.#surface.material = this.#materials[look];
    this.#lines.visible = look === "wireframe";
  }

  pose(controls: Float32Array): void {
    this.#face.evaluateInto(controls, { positions: this.positions, normals: this.normals });
    this.touch();
  }

  /** Sends to the graphics card what has changed. */
  touch(): void {
    for (const attribute of this.#attributes) attribute.needsUpdate = true;
  }

  override dispose(): void {
    this.#geometry.dispose();
    this.#lines.geometry.dispose();
    (this.#lines.material as Material).dispose();
    for (const material of Object.values(this.#materials)) material.dispose();
  }
}

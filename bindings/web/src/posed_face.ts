/** What the adapters for engines have in common: a face with the arrays that its poses go through. Needs no engine. */
import type { Image as Picture, Skin, TextureSlot } from "./contents.js";
import type { Face } from "./face.js";
import { renderMeshes, type RenderMesh } from "./render_mesh.js";

export interface FaceOptions {
  /** Whether the face is scaled to metres, which engines count in; by default it is in its own `units`. Refused where
   * those are not known. */
  metres?: boolean;
  /** Whether meshes are on the archive's skin, where it has one; true by default. */
  skin?: boolean;
  /** The level of detail whose polygons are drawn; 0, the whole, by default. */
  level?: number;
}

/** A face and its pose. Meshes are filled from `positions` and `normals` by `scatter`. */
export class PosedFace {
  readonly meshes: readonly RenderMesh[];
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  /** The smallest x, y and z, then the largest. */
  readonly bounds = new Float32Array(6);
  private readonly level: number;
  private readonly outputs: { positions: Float32Array; normals: Float32Array; bounds: Float32Array; lod: number };

  constructor(readonly face: Face, options: FaceOptions) {
    this.level = Math.min(options.level ?? 0, face.levels.length - 1);
    this.meshes = renderMeshes(face, face.levels[this.level]?.meshes);
    this.positions = new Float32Array(3 * face.vertexCount);
    this.normals = new Float32Array(3 * face.vertexCount);
    this.outputs = { positions: this.positions, normals: this.normals, bounds: this.bounds, lod: this.level };
    this.pose(face.restControls);
  }

  /** `lod`: between the level that is drawn and the next one, 0 to 1. */
  pose(controls: Float32Array, lod = 0): void {
    this.outputs.lod = this.level + lod;
    this.face.evaluateInto(controls, this.outputs);
  }
}

/** Joints and weights of each vertex of a mesh, four of each. */
export interface Influences {
  readonly joints: Uint16Array;
  readonly weights: Float32Array;
}

/** Influences of a vertex in engines. */
export const influenceCount = 4;

/** The four largest influences of each vertex, whose weights sum to 1; null where the mesh follows no joint. */
export function strongestInfluences(skin: Skin, render: RenderMesh): Influences | null {
  const joints = new Uint16Array(influenceCount * render.vertexCount), weights = new Float32Array(joints.length);
  let follows = false;
  render.source.forEach((vertex, v) => {
    const first = skin.influences * vertex;
    const order = Array.from({ length: skin.influences }, (_, i) => first + i)
      .filter((i) => skin.weights[i]! > 0)
      .sort((a, b) => skin.weights[b]! - skin.weights[a]!).slice(0, influenceCount);
    const sum = order.reduce((total, i) => total + skin.weights[i]!, 0);
    if (sum === 0) return;
    follows = true;
    order.forEach((i, k) => {
      joints[influenceCount * v + k] = skin.joints[i]!;
      weights[influenceCount * v + k] = skin.weights[i]! / sum;
    });
  });
  return follows ? { joints, weights } : null;
}

/** A frame, the upper three rows of a 4 x 4 matrix, as all sixteen numbers, column after column. */
export function columnsOf(f: readonly number[]): number[] {
  return [0, 1, 2, 3].flatMap((column) => [f[column]!, f[4 + column]!, f[8 + column]!, column === 3 ? 1 : 0]);
}

/** Whether pictures of a slot are colours, not numbers. */
export const isColour = (slot: TextureSlot): boolean => slot === "baseColour" || slot === "emissive";

/** The polygons without material have this one. */
export const plainMaterial = { colour: [0.479, 0.479, 0.479], roughness: 0.6 } as const;

/** A picture file, decoded by the browser: PNG, JPEG, WebP. Null, with a warning, where it cannot; null outside of one. */
export async function decodePicture({ name, bytes, mediaType }: Picture): Promise<HTMLImageElement | null> {
  if (typeof Image === "undefined") return null;
  const picture = new Image();
  picture.src = URL.createObjectURL(new Blob([bytes as Uint8Array<ArrayBuffer>], { type: mediaType }));
  try {
    await picture.decode();
    return picture;
  } catch {
    console.warn(`facebaker: picture "${name}" (${mediaType}) is left out: the browser cannot decode it`);
    return null;
  } finally {
    URL.revokeObjectURL(picture.src);
  }
}

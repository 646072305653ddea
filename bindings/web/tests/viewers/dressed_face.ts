// Texture coordinates and materials of all kinds for any face, with pictures in which left and right, top and bottom
// differ.
import { Face, type Image, type Level, type Material, type MaterialRun, type Mesh, type Texture, type TextureSlot } from "facebaker";

async function paint(name: string, draw: (to: OffscreenCanvasRenderingContext2D) => void): Promise<Image> {
  const canvas = new OffscreenCanvas(64, 64), to = canvas.getContext("2d")!;
  draw(to);
  const bytes = new Uint8Array(await (await canvas.convertToBlob({ type: "image/png" })).arrayBuffer());
  return { name, mediaType: "image/png", bytes };
}

const fill = (to: OffscreenCanvasRenderingContext2D, colour: string, x: number, y: number, width: number, height: number) => {
  to.fillStyle = colour;
  to.fillRect(x, y, width, height);
};

function paintAll(): Promise<Image[]> {
  return Promise.all([
    paint("colour", (to) => {
      fill(to, "#e8b89c", 0, 0, 64, 64);
      fill(to, "#c03020", 0, 0, 32, 20);
      fill(to, "#2050c0", 40, 40, 24, 24);
      fill(to, "#208040", 0, 50, 20, 14);
    }),
    paint("holes", (to) => {
      fill(to, "#d0c060", 0, 0, 64, 44);
      to.clearRect(8, 8, 20, 28);
    }),
    paint("occlusion, roughness, metal", (to) => {
      fill(to, "rgb(255, 160, 0)", 0, 0, 64, 64);
      fill(to, "rgb(140, 90, 100)", 0, 0, 30, 64);
    }),
    paint("bumps", (to) => {
      fill(to, "rgb(128, 128, 255)", 0, 0, 64, 64);
      fill(to, "rgb(200, 128, 220)", 0, 0, 32, 32);
      fill(to, "rgb(128, 200, 220)", 32, 32, 32, 32);
    }),
    paint("glow", (to) => {
      fill(to, "#000000", 0, 0, 64, 64);
      fill(to, "#40c0a0", 0, 32, 40, 16);
    }),
  ]);
}

const texture = (slot: TextureSlot, image: number, scale = 1, wrapU: Texture["wrapU"] = "repeat"): Texture =>
  ({ slot, image, wrapU, wrapV: "repeat", scale });

const base = { alphaMode: "opaque", alphaCutoff: 0.5, baseColour: [1, 1, 1, 1], metallic: 0, roughness: 0.7, emissive: [0, 0, 0],
               doubleSided: false, textures: [] } as const;

const materials: readonly Material[] = [
  { ...base, name: "skin", metallic: 1, roughness: 1, textures: [texture("baseColour", 0), texture("metallicRoughness", 2),
    texture("normal", 3, 0.8), texture("occlusion", 2, 0.9)] },
  { ...base, name: "lashes", alphaMode: "mask", doubleSided: true, textures: [texture("baseColour", 1, 1, "clamp")] },
  { ...base, name: "glowing", baseColour: [0.2, 0.1, 0.3, 1], emissive: [1, 0.8, 0.6], textures: [texture("emissive", 4, 1, "mirror")] },
  { ...base, name: "glass", alphaMode: "blend", baseColour: [0.4, 0.6, 0.9, 0.5], doubleSided: true },
];

// Which material polygons have, some after the others; -1: none.
const kinds = [0, 0, 0, 1, 0, 2, 0, 3, -1, 0];

interface Dress {
  readonly meshes: Mesh[];
  readonly uvs: Float32Array;
}

// Texture coordinates are seen from the front: with a seam, beyond which they are mirrored.
function dress(face: Face, meshes: readonly Mesh[]): Dress {
  const { restPositions: at, vertexCount: count } = face, uvs = new Float32Array(4 * count);
  const of = (axis: number) => Array.from({ length: count }, (_, v) => at[3 * v + axis]!);
  const [left, low] = [0, 1].map((axis) => Math.min(...of(axis))) as [number, number];
  const [right, high] = [0, 1].map((axis) => Math.max(...of(axis))) as [number, number];
  for (let v = 0; v < count; ++v) {
    const u = (at[3 * v]! - left) / (right - left), up = (at[3 * v + 1]! - low) / (high - low);
    uvs.set([u, up], 2 * v);
    uvs.set([1.5 - u, up], 2 * (count + v));
  }
  const dressed = meshes.map((mesh) => {
    const together = Math.ceil(mesh.polygonSizes.length / 60);
    const runs = Array.from(mesh.polygonSizes, (_, polygon) =>
      ({ polygonCount: 1, material: kinds[Math.floor(polygon / together) % kinds.length]! }));
    const uvCorners = mesh.polygonCorners.slice();
    let first = 0;
    for (const size of mesh.polygonSizes) {
      if (at[3 * mesh.polygonCorners[first]!]! > (left + right) / 2)
        for (let corner = first; corner < first + size; ++corner) uvCorners[corner]! += count;
      first += size;
    }
    return { ...mesh, runs: byMaterial(runs), uvCorners };
  });
  return { meshes: dressed, uvs };
}

// Runs of one material as one.
function byMaterial(runs: readonly MaterialRun[]): MaterialRun[] {
  const joined: MaterialRun[] = [];
  for (const run of runs) {
    const last = joined.at(-1);
    if (last?.material === run.material) joined.splice(-1, 1, { ...run, polygonCount: last.polygonCount + run.polygonCount });
    else joined.push(run);
  }
  return joined;
}

/** Gives every face of this page texture coordinates and these materials. */
export async function dressFaces(): Promise<void> {
  const images = await paintAll(), dressed = new WeakMap<Face, Dress>();
  const { meshes: { get: ownMeshes }, levels: { get: ownLevels } } = Object.getOwnPropertyDescriptors(Face.prototype);
  const dressOf = (face: Face) => {
    const before = dressed.get(face);
    if (before) return before;
    const made = dress(face, (ownMeshes as () => Mesh[]).call(face));
    dressed.set(face, made);
    return made;
  };
  Object.defineProperties(Face.prototype, {
    images: { get: () => images },
    materials: { get: () => materials },
    uvs: { get(this: Face) { return dressOf(this).uvs; } },
    meshes: { get(this: Face) { return dressOf(this).meshes; } },
    levels: { get(this: Face) {
      return (ownLevels as () => Level[]).call(this).map((level, index) => index === 0 ? { ...level, meshes: this.meshes } : level);
    } },
  });
}

// A face in one pose as a .glb file, which every viewer draws by a loader of its own: what adapters are compared with.
// Shares no code with them: vertices are those of the corners of triangles.
import type { Face, Material, Texture } from "facebaker";

export interface PosedVertices {
  readonly positions: Float32Array;
  readonly normals: Float32Array;
}

const floats = 5126, arrayBuffer = 34962;
const wraps = { repeat: 10497, clamp: 33071, mirror: 33648 };
const slots = {
  normal: "normalTexture", occlusion: "occlusionTexture", emissive: "emissiveTexture",
} as const;

// The one chunk of bytes of a .glb, with its views and accessors.
class Chunk {
  readonly views: object[] = [];
  readonly accessors: object[] = [];
  private readonly parts: Uint8Array[] = [];
  private length = 0;

  view(bytes: Uint8Array, target?: number): number {
    this.views.push({ buffer: 0, byteOffset: this.length, byteLength: bytes.length, ...(target && { target }) });
    const padded = new Uint8Array(4 * Math.ceil(bytes.length / 4));
    padded.set(bytes);
    this.parts.push(padded);
    this.length += padded.length;
    return this.views.length - 1;
  }

  numbers(values: readonly number[], components: 2 | 3, withRange: boolean): number {
    const of = (component: number) => values.filter((_, i) => i % components === component).map(Math.fround);
    const range = withRange && { min: [0, 1, 2].map((c) => of(c).reduce((a, b) => Math.min(a, b))),
                                 max: [0, 1, 2].map((c) => of(c).reduce((a, b) => Math.max(a, b))) };
    this.accessors.push({ bufferView: this.view(new Uint8Array(Float32Array.from(values).buffer), arrayBuffer),
                          componentType: floats, count: values.length / components, type: `VEC${components}`, ...range });
    return this.accessors.length - 1;
  }

  bytes(): Uint8Array {
    const all = new Uint8Array(this.length);
    let at = 0;
    for (const part of this.parts) {
      all.set(part, at);
      at += part.length;
    }
    return all;
  }
}

function materialOf(from: Material, textures: { index: (texture: Texture) => number }): object {
  const slot = (name: Texture["slot"]) => from.textures.find((texture) => texture.slot === name);
  const reference = (name: Texture["slot"]) => ({ index: textures.index(slot(name)!) });
  const material: Record<string, unknown> = {
    name: from.name, doubleSided: from.doubleSided, alphaMode: from.alphaMode.toUpperCase(), emissiveFactor: from.emissive,
    ...(from.alphaMode === "mask" && { alphaCutoff: from.alphaCutoff }),
    pbrMetallicRoughness: {
      baseColorFactor: from.baseColour, metallicFactor: from.metallic, roughnessFactor: from.roughness,
      ...(slot("baseColour") && { baseColorTexture: reference("baseColour") }),
      ...(slot("metallicRoughness") && { metallicRoughnessTexture: reference("metallicRoughness") }),
    },
  };
  for (const [name, key] of Object.entries(slots) as [keyof typeof slots, string][]) {
    const texture = slot(name);
    if (!texture) continue;
    const factor = name === "normal" ? { scale: texture.scale } : name === "occlusion" ? { strength: texture.scale } : {};
    material[key] = { ...reference(name), ...factor };
  }
  return material;
}

// Corners of the triangles of a mesh, by material: vertices and pairs of texture coordinates.
function trianglesOf(mesh: Face["meshes"][number]): Map<number, [vertex: number, pair: number][]> {
  const all = new Map<number, [number, number][]>();
  const runs = mesh.runs.flatMap(({ polygonCount, material }) => new Array<number>(polygonCount).fill(material));
  let first = 0;
  mesh.polygonSizes.forEach((corners, polygon) => {
    const material = runs[polygon] ?? -1, list = all.get(material) ?? [];
    for (let k = 1; k + 1 < corners; ++k)
      for (const corner of [first, first + k, first + k + 1])
        list.push([mesh.polygonCorners[corner]!, mesh.uvCorners?.[corner] ?? -1]);
    all.set(material, list);
    first += corners;
  });
  return all;
}

/** What polygons without material have in adapters. */
export const plainMaterial: Material = { name: "without material", alphaMode: "opaque", alphaCutoff: 0.5, baseColour: [0.479, 0.479, 0.479, 1],
                          metallic: 0, roughness: 0.6, emissive: [0, 0, 0], doubleSided: false, textures: [] };

/** What `facebaker export` gives a face that has no materials at all. */
export const clay: Material = { ...plainMaterial, name: "clay", baseColour: [0.5, 0.345, 0.275, 1], roughness: 0.7, doubleSided: true };

/** Normals of the triangles that polygons are cut into, by their areas, as `facebaker export` writes them; those of the
 * runtime are of whole polygons. */
export function normalsOfTriangles(face: Face, positions: Float32Array): Float32Array {
  const normals = new Float32Array(positions.length);
  const at = (v: number) => [0, 1, 2].map((axis) => positions[3 * v + axis]!) as [number, number, number];
  for (const { triangles } of face.meshes)
    for (let t = 0; t < triangles.length; t += 3) {
      const [a, b, c] = [at(triangles[t]!), at(triangles[t + 1]!), at(triangles[t + 2]!)];
      const [u, w] = [b, c].map((corner) => corner.map((value, axis) => value - a[axis]!)) as [number[], number[]];
      const normal = [0, 1, 2].map((axis) => u[(axis + 1) % 3]! * w[(axis + 2) % 3]! - u[(axis + 2) % 3]! * w[(axis + 1) % 3]!);
      for (let k = 0; k < 3; ++k) normal.forEach((value, axis) => { normals[3 * triangles[t + k]! + axis]! += value; });
    }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i]!, normals[i + 1]!, normals[i + 2]!) || 1;
    for (let axis = 0; axis < 3; ++axis) normals[i + axis]! /= length;
  }
  return normals;
}

/** `scale`: metres of a unit of the face; `plain`: the material of polygons without one, null: none. */
export function plainGlb(face: Face, posed: PosedVertices, scale: number, plain: Material | null): Uint8Array {
  const chunk = new Chunk(), textures: object[] = [], samplers: object[] = [];
  const images = face.images.map(({ bytes, mediaType }) => ({ bufferView: chunk.view(bytes), mimeType: mediaType }));
  const index = (texture: Texture) => {
    samplers.push({ wrapS: wraps[texture.wrapU], wrapT: wraps[texture.wrapV], minFilter: 9987, magFilter: 9729 });
    return textures.push({ source: texture.image, sampler: samplers.length - 1 }) - 1;
  };
  const materials = [...face.materials, ...(plain ? [plain] : [])].map((material) => materialOf(material, { index }));
  const meshes = face.meshes.map((mesh) => ({ name: mesh.name, primitives: [...trianglesOf(mesh)].map(([material, corners]) => ({
    attributes: {
      POSITION: chunk.numbers(corners.flatMap(([v]) => [0, 1, 2].map((c) => scale * posed.positions[3 * v + c]!)), 3, true),
      NORMAL: chunk.numbers(corners.flatMap(([v]) => [0, 1, 2].map((c) => posed.normals[3 * v + c]!)), 3, false),
      ...(mesh.uvCorners && { TEXCOORD_0: chunk.numbers(
        corners.flatMap(([, pair]) => [face.uvs![2 * pair]!, 1 - face.uvs![2 * pair + 1]!]), 2, false) }),
    },
    ...(material >= 0 ? { material } : plain ? { material: materials.length - 1 } : {}),
  })) }));
  const nodes = meshes.map((_, mesh) => ({ mesh }));
  const root = { children: nodes.map((_, node) => node), ...(face.upAxis === "z" && { rotation: [-Math.SQRT1_2, 0, 0, Math.SQRT1_2] }) };
  const bytes = chunk.bytes();
  return pack({ asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [nodes.length] }], nodes: [...nodes, root], meshes, materials,
                ...(textures.length > 0 && { textures, samplers, images }),
                accessors: chunk.accessors, bufferViews: chunk.views, buffers: [{ byteLength: bytes.length }] }, bytes);
}

function pack(document: object, bytes: Uint8Array): Uint8Array {
  const plainText = JSON.stringify(document), text = new TextEncoder().encode(plainText);
  const padded = 4 * Math.ceil(text.length / 4), file = new Uint8Array(28 + padded + bytes.length), view = new DataView(file.buffer);
  [0x46546c67, 2, file.length, padded, 0x4e4f534a].forEach((value, i) => view.setUint32(4 * i, value, true));
  file.fill(32, 20, 20 + padded).set(text, 20);
  view.setUint32(20 + padded, bytes.length, true);
  view.setUint32(24 + padded, 0x004e4942, true);
  file.set(bytes, 28 + padded);
  return file;
}

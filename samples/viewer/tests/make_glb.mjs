// Writes a glTF file of a square with two morph targets.
//   node make_glb.mjs masked|jaw|body OUT.glb
// masked: with an alpha-masked texture, opaque but for its rim.
// body: two metres high, of which the uppermost 25 cm move.
// jaw: on two joints, the lower of which an animation turns.
import { writeFileSync } from "node:fs";
import { crc32, deflateSync } from "node:zlib";

const SIDE = 9; // vertices
const TEXELS = 64;

/** A PNG file, red, green, blue and alpha of each texel by `colour(x, y)`. */
function png(size, colour) {
  const rows = Buffer.alloc(size * (1 + 4 * size));
  for (let y = 0; y < size; ++y)
    for (let x = 0; x < size; ++x) rows.set(colour(x, y), y * (1 + 4 * size) + 1 + 4 * x);
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]), size = Buffer.alloc(4), sum = Buffer.alloc(4);
    size.writeUInt32BE(data.length);
    sum.writeUInt32BE(crc32(body));
    return Buffer.concat([size, body, sum]);
  };
  const header = Buffer.alloc(13);
  header.writeUInt32BE(size, 0);
  header.writeUInt32BE(size, 4);
  header.set([8, 6], 8); // bits, RGBA
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", header), chunk("IDAT", deflateSync(rows)),
                        chunk("IEND", Buffer.alloc(0))]);
}

const grid = (make) => Float32Array.from(
  Array.from({ length: SIDE * SIDE }, (_, v) => make((v % SIDE) / (SIDE - 1), Math.floor(v / SIDE) / (SIDE - 1))).flat());
const [, , kind, out] = process.argv;
const body = kind === "body";
const positions = grid((x, y) => (body ? [0.25 * (x - 0.5), 2 * y, 0] : [x - 0.5, y - 0.5, 0]));
const normals = grid(() => [0, 0, 1]);
const uvs = grid((x, y) => [x, 1 - y]);
const moved = (y) => (!body ? 0.2 : y > 0.8 ? 0.02 : 0);
const targets = [grid((x, y) => [0, moved(y) * x * y, 0]), grid((x, y) => [0, 0, moved(y) * x * x])];
const indices = new Uint16Array(6 * (SIDE - 1) ** 2);
for (let cell = 0; cell < (SIDE - 1) ** 2; ++cell) {
  const a = Math.floor(cell / (SIDE - 1)) * SIDE + (cell % (SIDE - 1));
  indices.set([a, a + 1, a + SIDE, a + 1, a + SIDE + 1, a + SIDE], 6 * cell);
}

const parts = [], bufferViews = [], accessors = [];
function view(data) {
  const bytes = Buffer.from(data.buffer ?? data, data.byteOffset, data.byteLength);
  const byteOffset = parts.reduce((size, part) => size + part.length, 0);
  bufferViews.push({ buffer: 0, byteOffset, byteLength: bytes.length });
  parts.push(bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4));
  return bufferViews.length - 1;
}
function accessor(data, type, componentType, size) {
  const at = (pick, axis) => pick(...Array.from({ length: data.length / size }, (_, i) => data[size * i + axis]));
  const bounds = type === "VEC3" ? Object.fromEntries(["min", "max"].map((name) => [name, [0, 1, 2].map((axis) => at(Math[name], axis))])) : {};
  accessors.push({ bufferView: view(data), componentType, count: data.length / size, type, ...bounds });
  return accessors.length - 1;
}
const FLOAT = 5126, SHORT = 5123;
const primitive = {
  attributes: { POSITION: accessor(positions, "VEC3", FLOAT, 3), NORMAL: accessor(normals, "VEC3", FLOAT, 3),
                TEXCOORD_0: accessor(uvs, "VEC2", FLOAT, 2) },
  indices: accessor(indices, "SCALAR", SHORT, 1), material: 0,
  targets: targets.map((target) => ({ POSITION: accessor(target, "VEC3", FLOAT, 3) })),
};
const document = {
  asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ name: kind, mesh: 0 }],
  meshes: [{ name: kind, primitives: [primitive], weights: [0, 0], extras: { targetNames: ["lift", "bend"] } }],
  materials: [{ name: kind, doubleSided: true, pbrMetallicRoughness: { metallicFactor: 0 } }], bufferViews, accessors,
};

function addMask() {
  const inside = (x) => x > 1 && x < TEXELS - 2;
  const image = png(TEXELS, (x, y) => [255, 0, 200, inside(x) && inside(y) ? 255 : 0]);
  const [material] = document.materials;
  Object.assign(material, { alphaMode: "MASK", alphaCutoff: 0.5 });
  material.pbrMetallicRoughness.baseColorTexture = { index: 0 };
  Object.assign(document, { textures: [{ source: 0 }], images: [{ bufferView: view(image), mimeType: "image/png" }] });
}

/** What is below the joint at the middle follows it, the more the lower it is; it nods and comes back in a second. */
function addJaw() {
  const follows = grid((_, y) => Math.min(1, Math.max(0, 3 * (0.5 - y))));
  const joints = Uint16Array.from({ length: 4 * SIDE * SIDE }, (_, i) => (i % 4 === 1 ? 1 : 0));
  const weights = Float32Array.from(joints, (_, i) => [1 - follows[i >> 2], follows[i >> 2], 0, 0][i % 4]);
  Object.assign(primitive.attributes, { JOINTS_0: accessor(joints, "VEC4", SHORT, 4),
                                        WEIGHTS_0: accessor(weights, "VEC4", FLOAT, 4) });
  const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  const binds = accessor(Float32Array.from([...identity, ...identity]), "MAT4", FLOAT, 16);
  const turn = (angle) => [Math.sin(angle / 2), 0, 0, Math.cos(angle / 2)];
  const times = accessor(Float32Array.of(0, 0.5, 1), "SCALAR", FLOAT, 1);
  const turns = accessor(Float32Array.from([0, 0.8, 0].flatMap(turn)), "VEC4", FLOAT, 4);
  document.nodes[0].skin = 0;
  document.nodes.push({ name: "head", children: [2] }, { name: "jaw" });
  document.scenes[0].nodes.push(1);
  Object.assign(document, {
    skins: [{ joints: [1, 2], inverseBindMatrices: binds }],
    animations: [{ name: "nod", samplers: [{ input: times, output: turns }],
                   channels: [{ sampler: 0, target: { node: 2, path: "rotation" } }] }],
  });
  Object.assign(accessors[times], { min: [0], max: [1] });
}

({ masked: addMask, jaw: addJaw, body: () => undefined })[kind]();
const binary = Buffer.concat(parts);
document.buffers = [{ byteLength: binary.length }];
const text = Buffer.from(JSON.stringify(document));
const json = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, " ")]);
const words = (...numbers) => Buffer.from(Uint32Array.from(numbers).buffer);
writeFileSync(out, Buffer.concat([
  words(0x46546c67, 2, 28 + json.length + binary.length), words(json.length, 0x4e4f534a), json, words(binary.length, 0x4e4942), binary]));

// Writes a small character as a dataset folder: five meshes with UV seams, five materials with textures in all slots,
// three sockets, and four controls of which two do more together than apart. Its images are PNG and JPEG or, with
// "ktx2", KTX2. With "skin" it is on a neck of two joints, and its eyes have joints of their own. With "driven" its
// controls move joints of a jaw and of eyes; with "carried" both.
//   node make_character.mjs FOLDER [ktx2|skin|driven|carried]
import fs from "node:fs";
import path from "node:path";
import zlib from "node:zlib";

const [folder, kind] = process.argv.slice(2);
fs.mkdirSync(folder, { recursive: true });

function write(name, bytes) {
  fs.writeFileSync(path.join(folder, name), bytes);
}

function writeNpy(name, shape, values, numbers = Float32Array) {
  const text = `{'descr': '<${numbers === Float32Array ? "f4" : "i4"}', 'fortran_order': False, 'shape': (${shape.join(", ")},), }`;
  const header = text.padEnd(Math.ceil((text.length + 11) / 64) * 64 - 11) + "\n";
  const start = Buffer.from("\x93NUMPY\x01\x00\0\0" + header, "latin1");
  start.writeUInt16LE(header.length, 8);
  write(name, Buffer.concat([start, Buffer.from(numbers.from(values).buffer)]));
}

// ---- Images

// `size` x `size` pixels of two colours, in squares.
function png(size, first, second) {
  const chunk = (kind, data) => {
    const body = Buffer.concat([Buffer.from(kind, "latin1"), data]);
    const ends = Buffer.alloc(8);
    ends.writeUInt32BE(data.length, 0);
    ends.writeUInt32BE(crc32(body), 4);
    return Buffer.concat([ends.subarray(0, 4), body, ends.subarray(4)]);
  };
  const header = Buffer.from([0, 0, 0, size, 0, 0, 0, size, 8, 2, 0, 0, 0]);
  const rows = [];
  for (let y = 0; y < size; ++y) {
    rows.push(0);
    for (let x = 0; x < size; ++x) rows.push(...(((x >> 1) + (y >> 1)) & 1 ? first : second));
  }
  const parts = [chunk("IHDR", header), chunk("IDAT", zlib.deflateSync(Buffer.from(rows))), chunk("IEND", Buffer.alloc(0))];
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), ...parts]);
}

function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; ++bit) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

// 8 x 8 grey pixels: one block whose only symbols are "no change" and "end of block", of one bit each.
function jpeg() {
  const segment = (marker, ...data) => [0xff, marker, 0, data.length + 2, ...data];
  const codes = [1, ...Array(15).fill(0), 0];
  return Buffer.from([0xff, 0xd8, ...segment(0xdb, 0, ...Array(64).fill(1)), ...segment(0xc0, 8, 0, 8, 0, 8, 1, 1, 0x11, 0),
    ...segment(0xc4, 0x00, ...codes), ...segment(0xc4, 0x10, ...codes), ...segment(0xda, 1, 1, 0, 0, 63, 0), 0x3f, 0xff, 0xd9]);
}

// 4 x 4 pixels: one block of UASTC.
function ktx2() {
  const file = Buffer.alloc(104 + 44 + 12 + 16);  // header and index, description, padding, one level
  Buffer.from("\xabKTX 20\xbb\r\n\x1a\n", "latin1").copy(file);
  [0, 1, 4, 4, 0, 0, 1, 1, 0, 104, 44, 0, 0].forEach((value, i) => file.writeUInt32LE(value, 12 + 4 * i));
  [160, 16, 16].forEach((value, i) => file.writeBigUInt64LE(BigInt(value), 80 + 8 * i));
  const description = [44, 0, 2 | (40 << 16), 166 | (1 << 8) | (2 << 16), 3 | (3 << 8), 16, 0, 127 << 16, 0, 0, 0xffffffff];
  description.forEach((value, i) => file.writeUInt32LE(value >>> 0, 104 + 4 * i));
  return file;
}

const pictures = kind === "ktx2"
  ? [["skin", "ktx2", ktx2()], ["detail", "ktx2", ktx2()], ["grey", "ktx2", ktx2()]]
  : [["skin", "png", png(8, [224, 176, 160], [208, 150, 130])], ["detail", "png", png(4, [128, 128, 255], [140, 120, 250])],
     ["grey", "jpeg", jpeg()]];

// ---- Meshes

// A grid of rings around y; the seam of the texture coordinates is where a ring closes.
function rings(centre, radius, columns, rows) {
  const mesh = { points: [], uvs: [], faces: [] };
  for (let r = 0; r < rows; ++r)
    for (let c = 0; c <= columns; ++c) {
      const up = Math.PI * (0.1 + 0.8 * r / (rows - 1)), around = 2 * Math.PI * c / columns;
      mesh.uvs.push([c / columns, r / (rows - 1)]);
      if (c === columns) continue;
      mesh.points.push([centre[0] + radius * Math.sin(up) * Math.sin(around), centre[1] - radius * Math.cos(up),
        centre[2] + radius * Math.sin(up) * Math.cos(around)]);
    }
  for (let r = 0; r + 1 < rows; ++r)
    for (let c = 0; c < columns; ++c) {
      const v = (ring, column) => [ring * columns + column % columns, ring * (columns + 1) + column];
      mesh.faces.push([v(r, c), v(r, c + 1), v(r + 1, c + 1), v(r + 1, c)]);
    }
  return mesh;
}

const parts = {
  head: rings([0, 0, 0], 10, 24, 16), teeth: rings([0, -4, 6], 2, 10, 4), tongue: rings([0, -5, 5], 1.5, 8, 5),
  eye_L: rings([3, 3, 8], 1.2, 10, 8), eye_R: rings([-3, 3, 8], 1.2, 10, 8),
};
const runs = {
  head: [[300, 0], [60, 4]], teeth: [[30, 1]], tongue: [[32, 2]], eye_L: [[70, 3]], eye_R: [[60, 3], [10, null]],
};

// Positions of a mesh's points with jawOpen, smile, blink_L and look.
function posed(name, points, [jaw, smile, blink, look]) {
  const turn = (p, angle, [, y, z]) => [p[0], y + (p[1] - y) * Math.cos(angle) - (p[2] - z) * Math.sin(angle),
    z + (p[1] - y) * Math.sin(angle) + (p[2] - z) * Math.cos(angle)];
  const bell = (p, at, width) => Math.exp(-((p[0] - at[0]) ** 2 + (p[1] - at[1]) ** 2 + (p[2] - at[2]) ** 2) / width ** 2);
  return points.map((p) => {
    if (name.startsWith("eye")) {
      const x = p[0] - Math.sign(p[0]) * 3, z = p[2] - 8, angle = 0.5 * look;
      return [p[0] - x + x * Math.cos(angle) + z * Math.sin(angle), p[1], 8 - x * Math.sin(angle) + z * Math.cos(angle)];
    }
    if (name !== "head") return turn(p, 0.4 * jaw, [0, 0, 0]);
    const [x, y, z] = turn(p, 0.4 * jaw * bell(p, [0, -6, 6], 6), [0, 0, 0]);
    const corners = smile * (bell(p, [4, -4, 7], 2.5) + bell(p, [-4, -4, 7], 2.5));
    return [x + Math.sign(x) * corners * (1 - 0.6 * jaw), y + 0.7 * corners - blink * bell(p, [3, 4, 8], 2), z];
  });
}

// The share of a vertex that follows a driven joint, in the steps of archives, and that joint: 0 is the jaw, 1 and 2 are eyes.
const eyes = { eye_L: 1, eye_R: 2 };
function drivenBy(name, p) {
  const share = name === "head" ? Math.exp(-(p[0] ** 2 + (p[1] + 6) ** 2 + (p[2] - 6) ** 2) / 36) : 1;
  return [eyes[name] ?? 0, Math.round(share * 32768) / 32768];
}

// The same as posed(), but that the jaw's turn is shared by skinning.
function drivenPoints(name, points, [jaw, smile, blink, look]) {
  return posed(name, points, [0, smile, blink, 0]).map((p, v) => {
    const [joint, share] = drivenBy(name, points[v]), angle = joint ? 0.5 * look : 0.4 * jaw;
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const [x, z] = [p[0] - (joint === 1 ? 3 : joint === 2 ? -3 : 0), p[2] - (joint ? 8 : 0)];
    const turned = joint ? [p[0] - x + x * cos + z * sin, p[1], p[2] - z - x * sin + z * cos]
      : [p[0], p[1] * cos - p[2] * sin, p[1] * sin + p[2] * cos];
    return p.map((number, axis) => number + share * (turned[axis] - number));
  });
}

const driven = kind === "driven" || kind === "carried", skinned = kind === "skin" || kind === "carried";
const all = Object.entries(parts);
const controls = [
  { name: "jawOpen", min: 0, max: 1, default: 0, arkit: "jawOpen" }, { name: "smile", min: 0, max: 1, default: 0 },
  { name: "blink_L", min: 0, max: 1, default: 0, arkit: "eyeBlinkLeft" }, { name: "look", min: -1, max: 1, default: 0 },
];
const frames = 160, values = [], points = [], numbers = [];
for (let f = 0; f < frames; ++f) {
  const wave = (speed, low) => low + (1 - low) * (0.5 - 0.5 * Math.cos(speed * f));
  const pose = [wave(0.21, 0), wave(0.13, 0), wave(0.47, 0), wave(0.17, -1)];
  values.push(...pose);
  for (const [name, mesh] of all) points.push(...(driven ? drivenPoints : posed)(name, mesh.points, pose).flat());
  numbers.push(0.4 * pose[0], 0.5 * pose[3], 0.5 * pose[3]);
}
let text = "", firstVertex = 1, firstUv = 1, faces = "";
for (const [, mesh] of all) {
  text += mesh.points.map((p) => `v ${posed("", [p], [0, 0, 0, 0])[0].map(Math.fround).join(" ")}\n`).join("");
  text += mesh.uvs.map((uv) => `vt ${uv.join(" ")}\n`).join("");
  for (const face of mesh.faces) faces += `f ${face.map(([v, uv]) => `${v + firstVertex}/${uv + firstUv}`).join(" ")}\n`;
  firstVertex += mesh.points.length;
  firstUv += mesh.uvs.length;
}
write("rest.obj", text + faces);
const count = all.reduce((sum, [, mesh]) => sum + mesh.points.length, 0);
writeNpy("motion.controls.npy", [frames, 4], values);
writeNpy("motion.points.npy", [frames, count, 3], points);
writeNpy("clip.npy", [24, 4], values.slice(0, 24 * 4));
for (const [name, type, bytes] of pictures) write(`${name}.${type}`, bytes);

let body = {};
const at = (x, y, z) => [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z];
if (skinned) {
  const followed = [], weights = [];
  for (const [name, mesh] of all)
    for (const [, y] of mesh.points) {
      const eye = name.startsWith("eye"), share = eye || name !== "head" ? 1 : Math.min(1, Math.fround((y + 10) / 8));
      followed.push(name === "eye_L" ? 2 : name === "eye_R" ? 3 : 1, 0);
      weights.push(share, 1 - share);
    }
  writeNpy("skin_joints.npy", [count, 2], followed, Int32Array);
  writeNpy("skin_weights.npy", [count, 2], weights);
  body = {
    joints: [{ name: "neck", rest: at(0, -12, 0) }, { name: "skull", parent: 0, rest: at(0, 8, -1) },
      { name: "eye joint L", parent: 1, rest: at(3, 7, 9) }, { name: "eye joint R", parent: 1, rest: at(-3, 7, 9) }],
    skin: { joints: "skin_joints.npy", weights: "skin_weights.npy" },
  };
}
const clip = { name: "motion", kind: "excitation", controls: "motion.controls.npy", points: "motion.points.npy" };
if (driven) {
  const followed = all.flatMap(([name, mesh]) => mesh.points.map((p) => drivenBy(name, p)));
  writeNpy("driven_joints.npy", [count, 1], followed.map(([joint]) => joint), Int32Array);
  writeNpy("driven_weights.npy", [count, 1], followed.map(([, share]) => share));
  writeNpy("motion.channels.npy", [frames, 3], numbers);
  clip.channels = "motion.channels.npy";
  body.driven_joints = [{ name: "jaw", numbers: ["rotate_x"], frame: at(0, 0, 0) },
    { name: "eye.L", numbers: ["rotate_y"], frame: at(3, 3, 8) }, { name: "eye.R", numbers: ["rotate_y"], frame: at(-3, 3, 8) }];
  body.driven_skin = { joints: "driven_joints.npy", weights: "driven_weights.npy" };
}

const texture = (slot, image, more) => ({ slot, image, ...more });
write("dataset.json", JSON.stringify({
  format: "facebaker-dataset", version: 1, name: "five meshes", units: "cm", up_axis: "y", rest: "rest.obj", controls,
  clips: [clip],
  meshes: all.map(([name, mesh]) => ({
    name, vertices: mesh.points.length, polygons: mesh.faces.length,
    materials: runs[name].map(([polygons, material]) => (material === null ? { polygons } : { polygons, material })),
  })),
  materials: [
    { name: "skin", metallic: 0, roughness: 0.6, base_colour: [1, 0.9, 0.8, 1], emissive: [0.25, 0.125, 0],
      textures: [texture("base_colour", 0), texture("normal", 1, { scale: 0.5, wrap_u: "clamp", wrap_v: "mirror" }),
        texture("metallic_roughness", 2), texture("occlusion", 2, { scale: 0.25 }), texture("emissive", 0)] },
    { name: "enamel", metallic: 0, roughness: 0.2, base_colour: [1, 1, 0.9, 1] },
    { name: "tongue", metallic: 0.5, textures: [texture("base_colour", 0, { wrap_u: "mirror" })] },
    { name: "cornea", base_colour: [1, 1, 1, 0.25], alpha_mode: "blend", roughness: 0, emissive: [0, 2, 0] },
    { name: "brow", alpha_mode: "mask", alpha_cutoff: 0.25, double_sided: true, textures: [texture("base_colour", 1)] },
  ],
  images: pictures.map(([name, type]) => ({ name, media_type: `image/${type}`, file: `${name}.${type}` })),
  sockets: [{ name: "glasses", vertices: [200, 210, 230, 240] }, { name: "chin", vertices: [50, 60, 70, 80, 90] },
    { name: "brace", vertices: [385, 390, 395, 400], frame: [0, 1, 0, 1, -1, 0, 0, -4, 0, 0, 1, 8] }],
  ...body,
}, null, 1));

// Loads a character that pose has written, by three.js' GLTFLoader, and compares it with the dataset folder that it
// was baked from: meshes, materials with factors, textures, images and how they go on beyond their borders, sockets.
// With FRAMES, .obj files of the frames of the animation, its posed points are compared, too.
//   node load_in_three.mjs FILE.glb FOLDER [DISTANCE FRAME.obj...]
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const [file, folder, distance, ...frames] = process.argv.slice(2);

// What the loader expects of a browser. Images stay the bytes they are.
globalThis.self = globalThis;
globalThis.createImageBitmap = async (blob) => ({ width: 1, height: 1, bytes: Buffer.from(await blob.arrayBuffer()) });
const ktx2 = {
  load: async (url, done) => {
    const bytes = Buffer.from(await (await fetch(url)).arrayBuffer());
    done(new THREE.Texture({ width: 1, height: 1, bytes }));
  },
};

const dataset = JSON.parse(fs.readFileSync(path.join(folder, "dataset.json")));
const bytes = fs.readFileSync(file);
const loader = new GLTFLoader().setKTX2Loader(ktx2);
const gltf = await loader.parseAsync(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), "");
gltf.scene.updateMatrixWorld(true);

function near(found, expected, what) {
  [found].flat().forEach((number, i) => {
    const other = [expected].flat()[i];
    assert.ok(Math.abs(number - other) < 1e-5, `${what}: ${found} where ${expected} should be`);
  });
}

const slots = { base_colour: "map", normal: "normalMap", metallic_roughness: "roughnessMap", occlusion: "aoMap", emissive: "emissiveMap" };
const wraps = { repeat: THREE.RepeatWrapping, clamp: THREE.ClampToEdgeWrapping, mirror: THREE.MirroredRepeatWrapping };

function checkTexture(found, expected, what) {
  const image = dataset.images[expected.image];
  assert.ok(found.image.bytes.equals(fs.readFileSync(path.join(folder, image.file))), `${what}: other bytes`);
  assert.equal(found.wrapS, wraps[expected.wrap_u ?? "repeat"], `${what}: wrap_u`);
  assert.equal(found.wrapT, wraps[expected.wrap_v ?? "repeat"], `${what}: wrap_v`);
}

function checkMaterial(found, expected) {
  const what = expected.name, colour = expected.base_colour ?? [1, 1, 1, 1];
  assert.equal(found.name, expected.name);
  near(found.color.toArray(), colour.slice(0, 3), `${what}: base colour`);
  near(found.opacity, expected.alpha_mode === "blend" ? colour[3] : 1, `${what}: alpha`);
  near(found.metalness, expected.metallic ?? 1, `${what}: metallic`);
  near(found.roughness, expected.roughness ?? 1, `${what}: roughness`);
  near(found.emissive.toArray().map((c) => c * found.emissiveIntensity), expected.emissive ?? [0, 0, 0], `${what}: emissive`);
  assert.equal(found.transparent, expected.alpha_mode === "blend", `${what}: blend`);
  near(found.alphaTest, expected.alpha_mode === "mask" ? expected.alpha_cutoff : 0, `${what}: cutoff`);
  assert.equal(found.side, expected.double_sided ? THREE.DoubleSide : THREE.FrontSide, `${what}: double sided`);
  const textures = Object.fromEntries((expected.textures ?? []).map((texture) => [texture.slot, texture]));
  for (const [slot, map] of Object.entries(slots)) {
    assert.equal(Boolean(found[map]), slot in textures, `${what}: ${slot}`);
    if (found[map]) checkTexture(found[map], textures[slot], `${what}: ${slot}`);
  }
  if (textures.normal) near(found.normalScale.x, textures.normal.scale ?? 1, `${what}: normal scale`);
  if (textures.occlusion) near(found.aoMapIntensity, textures.occlusion.scale ?? 1, `${what}: occlusion strength`);
}

// A mesh of several materials is a group of meshes, one for each.
function primitivesOf(name) {
  const found = gltf.scene.getObjectByName(name);
  assert.ok(found, `there is no ${name}`);
  return found.isMesh ? [found] : found.children;
}

const shown = new Set();
for (const mesh of dataset.meshes) {
  const primitives = primitivesOf(mesh.name);
  assert.equal(primitives.length, mesh.materials.length, `runs of ${mesh.name}`);
  mesh.materials.forEach(({ polygons, material }, run) => {
    assert.equal(primitives[run].geometry.index.count, 6 * polygons, `triangles of ${mesh.name}`);
    if (material === undefined) return assert.equal(primitives[run].material.name, "", `${mesh.name} has no material`);
    checkMaterial(primitives[run].material, dataset.materials[material]);
    shown.add(material);
  });
}
assert.equal(shown.size, dataset.materials.length, "materials");
for (const { name, frame } of dataset.sockets) {
  const socket = gltf.scene.getObjectByName(name);
  assert.ok(socket && !socket.isMesh, `there is no socket ${name}`);
  if (!frame || gltf.animations.length) continue;
  const matrix = new THREE.Matrix4().set(...frame, 0, 0, 0, 1);
  near(socket.matrix.toArray(), matrix.toArray(), `socket ${name}`);
}

// Joints of the host come first; driven ones are below them, or below one that stays. Targets of controls do without.
const controls = file.endsWith("-targets.glb"), driven = (controls ? null : dataset.driven_joints) ?? [];
const joints = [...(dataset.joints ?? []), ...driven];
for (const mesh of dataset.meshes)
  assert.equal(primitivesOf(mesh.name).every((primitive) => primitive.isSkinnedMesh === true), joints.length > 0, "skin");
if (joints.length) {
  const names = primitivesOf(dataset.meshes[0].name)[0].skeleton.bones.map((bone) => bone.userData.name ?? bone.name);
  if (!driven.length) assert.equal(names.length, joints.length, "joints");
  (dataset.joints ?? []).forEach((joint, j) => assert.equal(names[j], joint.name, "names of joints"));
  for (const joint of driven) assert.ok(names.includes(joint.name), `there is no ${joint.name}`);
}

// Points of all meshes in the archive's order, in its unit. Those of skinned meshes come in metres, with y up; joints of
// the host are as they were bound.
function posedPoints(mixer, time) {
  mixer.setTime(time);
  gltf.scene.updateMatrixWorld(true);
  const points = [];
  for (const mesh of dataset.meshes) {
    const [primitive] = primitivesOf(mesh.name);
    const unit = primitive.isSkinnedMesh ? 100 : 1;
    for (let v = 0; v < mesh.vertices; ++v)
      points.push(...primitive.getVertexPosition(v, new THREE.Vector3()).multiplyScalar(unit).toArray());
  }
  return points;
}

let largest = 0;
if (frames.length) {
  const mixer = new THREE.AnimationMixer(gltf.scene);
  mixer.clipAction(gltf.animations[0]).play();
  frames.forEach((frame, f) => {
    const lines = fs.readFileSync(frame, "utf8").split("\n").filter((line) => line.startsWith("v "));
    const expected = lines.flatMap((line) => line.slice(2).split(" ").map(Number));
    // A hair before the end, where the clip would begin again.
    const found = posedPoints(mixer, Math.min(f / 24, gltf.animations[0].duration - 1e-6));
    assert.equal(found.length, expected.length);
    for (let i = 0; i < found.length; ++i) largest = Math.max(largest, Math.abs(found[i] - expected[i]));
  });
  assert.ok(largest <= Number(distance), `points lie up to ${largest} off`);
}
console.log(`${file}: ${dataset.meshes.length} meshes, ${shown.size} materials, ${dataset.sockets.length} sockets agree` +
  (frames.length ? `; ${frames.length} frames, off by at most ${largest.toPrecision(2)}` : ""));

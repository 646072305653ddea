// Compares what `facebaker sample FILE` recorded of a glTF file with what three.js makes of the file: frames of its
// animations, by an AnimationMixer, and other poses, by morph targets and joints set from their controls. Positions that
// were recorded before skinning are skinned by the recorded joints first, as they are at rest.
//   node compare_with_three.mjs FILE DATASET [FRAMES_A_CLIP]
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";

const [file, folder, perClip = "6"] = process.argv.slice(2);
globalThis.self = globalThis;

// ---- The dataset

const dataset = JSON.parse(fs.readFileSync(path.join(folder, "dataset.json")));

function readNpy(name) {
  const bytes = fs.readFileSync(path.join(folder, name));
  const length = bytes.readUInt16LE(8), header = bytes.toString("latin1", 10, 10 + length);
  const shape = header.match(/'shape': \(([^)]*)\)/)[1].split(",").filter((x) => x.trim()).map(Number);
  const kinds = { "<f4": Float32Array, "<i4": Int32Array, "<u2": Uint16Array };
  const Numbers = kinds[header.match(/'descr': '([^']*)'/)[1]];
  const data = bytes.buffer.slice(bytes.byteOffset + 10 + length, bytes.byteOffset + bytes.length);
  return { shape, values: new Numbers(data) };
}

// Frame `frame` of a clip, which may lie in shards.
function pointsOf(clip, frame) {
  for (const name of [clip.points].flat()) {
    const [frames] = npy(name).shape;
    if (frame < frames) return slice(name, frame);
    frame -= frames;
  }
  assert.fail(`clip ${clip.name} is too short`);
}
const files = new Map();
function npy(name) {
  if (!files.has(name)) files.set(name, readNpy(name));
  return files.get(name);
}
function slice(name, frame) {
  const { shape, values } = npy(name), width = values.length / shape[0];
  return values.subarray(frame * width, (frame + 1) * width);
}

// ---- The recorded skin

// A 4 x 4 matrix of its upper three rows.
const matrixOf = (rows) => new THREE.Matrix4().set(...rows, 0, 0, 0, 1);
const skin = dataset.skin && { joints: npy(dataset.skin.joints), weights: npy(dataset.skin.weights) };
const places = [], matrices = [];
for (const joint of skin ? dataset.joints : []) {
  const rest = matrixOf(joint.rest);
  places.push(joint.parent === undefined ? rest : places[joint.parent].clone().multiply(rest));
  matrices.push(places.at(-1).clone().multiply(matrixOf(joint.inverse_bind)).elements);
}
function skinned(points) {
  if (!skin) return points;
  const width = skin.joints.shape[1];
  return points.map((x, i) => {
    const v = Math.floor(i / 3), axis = i % 3, at = points.subarray(3 * v, 3 * v + 3);
    let sum = 0, whole = 0;
    for (let k = v * width; k < (v + 1) * width; ++k) {
      const m = matrices[skin.joints.values[k]], weight = skin.weights.values[k];
      if (!(weight > 0)) continue;
      whole += weight;
      sum += weight * (m[axis] * at[0] + m[4 + axis] * at[1] + m[8 + axis] * at[2] + m[12 + axis]);
    }
    return whole > 0 ? sum : x;
  });
}

// ---- The file, by three.js

const bytes = fs.readFileSync(file);
const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
// Without materials, whose images nothing here decodes.
loader.register((parser) => ({
  name: "geometry",
  beforeRoot: async () => {
    parser.json.materials = parser.json.textures = parser.json.images = undefined;
    for (const mesh of parser.json.meshes) for (const primitive of mesh.primitives) delete primitive.material;
    for (const key of ["extensionsUsed", "extensionsRequired"])
      parser.json[key] = parser.json[key]?.filter((name) => !/_(materials|texture)_/.test(name));
  },
}));
const gltf = await loader.parseAsync(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length),
  path.dirname(file) + "/");
const { json, associations } = gltf.parser;

// Primitives as three.js shows them, in the order of nodes; those that share vertices with one before are left out.
const shown = [];
gltf.scene.traverse((object) => {
  if (!object.isMesh) return;
  const { meshes, primitives = 0 } = associations.get(object);
  let node = object;
  while (associations.get(node)?.nodes === undefined) node = node.parent;
  shown.push({ object, node: associations.get(node).nodes, mesh: meshes, primitive: primitives });
});
shown.sort((a, b) => a.node - b.node || a.primitive - b.primitive);
const vertices = shown.filter(({ node, mesh, primitive }, i) => {
  const key = (p) => JSON.stringify([json.meshes[mesh].primitives[p].attributes, json.meshes[mesh].primitives[p].targets]);
  return !shown.slice(0, i).some((other) => other.node === node && key(other.primitive) === key(primitive));
});
const nodesByName = new Map(), rest = new Map();
for (const [object, association] of associations)
  if (association?.nodes !== undefined && object.isObject3D) {
    const { nodes } = association;
    const name = json.nodes[nodes].name ?? `node${nodes}`;
    if (!nodesByName.has(name)) nodesByName.set(name, []);
    nodesByName.get(name).push(object);
    rest.set(object, { position: object.position.clone(), quaternion: object.quaternion.clone(), scale: object.scale.clone() });
  }
const weightsAtRest = new Map(shown.map(({ object }) => [object, object.morphTargetInfluences?.slice()]));

function reset() {
  for (const [object, { position, quaternion, scale }] of rest) {
    object.position.copy(position);
    object.quaternion.copy(quaternion);
    object.scale.copy(scale);
  }
  for (const [object, weights] of weightsAtRest) weights?.forEach((weight, t) => { object.morphTargetInfluences[t] = weight; });
}

function shownPoints() {
  gltf.scene.updateMatrixWorld(true);
  const points = [], at = new THREE.Vector3();
  for (const { object } of vertices)
    for (let v = 0; v < object.geometry.attributes.position.count; ++v) {
      object.getVertexPosition(v, at).applyMatrix4(object.matrixWorld);
      points.push(at.x, at.y, at.z);
    }
  return points;
}

// Expressions of avatars are mixtures of morph targets, which three.js does not know of: poses with them are left out.
const targetsOf = ({ mesh }) => json.meshes[mesh].extras?.targetNames ?? json.meshes[mesh].primitives[0].extras?.targetNames;
function setControls(values) {
  reset();
  const turns = new Map();
  for (const [c, { name, default: atRest }] of dataset.controls.entries()) {
    let known = false;
    for (const one of shown) {
      const target = targetsOf(one)?.indexOf(name) ?? -1;
      if (target < 0) continue;
      one.object.morphTargetInfluences[target] = values[c];
      known = true;
    }
    if (known) continue;
    const [, joint, kind, axis] = name.match(/^(.*)\.([trs])([xyz])$/) ?? [];
    const [object, ...more] = nodesByName.get(joint) ?? [];
    if (!object || more.length) {
      if (values[c] !== atRest) return false;
      continue;
    }
    if (kind === "t") object.position[axis] += values[c];
    if (kind === "s") object.scale[axis] += values[c];
    if (kind === "r") turns.set(object, { x: 0, y: 0, z: 0, ...turns.get(object), [axis]: values[c] * Math.PI / 180 });
  }
  for (const [object, { x, y, z }] of turns) {
    const axis = new THREE.Vector3(x, y, z), angle = axis.length();
    if (angle > 0) object.quaternion.multiply(new THREE.Quaternion().setFromAxisAngle(axis.normalize(), angle));
  }
  return true;
}

// ---- Comparing

const box = new THREE.Box3().setFromArray(shownPoints());
const diagonal = box.getSize(new THREE.Vector3()).length();
function distance(clip, frame) {
  const expected = shownPoints(), found = skinned(pointsOf(clip, frame));
  assert.equal(found.length, expected.length, "numbers of coordinates");
  let largest = 0;
  for (let i = 0; i < found.length; i += 3)
    largest = Math.max(largest, Math.hypot(found[i] - expected[i], found[i + 1] - expected[i + 1], found[i + 2] - expected[i + 2]));
  return largest / diagonal;
}

// What an animation moves here: without joints as controls, weights alone.
const jointControls = dataset.controls.some(({ name }) => /\.[trs][xyz]$/.test(name));
function animationOf(clip) {
  const [, whole, first] = clip.name.match(/^(.*) \[(\d+)-\d+\]$/) ?? [clip.name, clip.name, 0];  // a stretch of it
  const animation = gltf.animations.find(({ name }) => name === whole);
  if (!animation) return undefined;
  const tracks = animation.tracks.filter(({ name }) => jointControls || name.endsWith(".morphTargetInfluences"));
  if (!tracks.length) return undefined;
  const start = Math.min(...tracks.map(({ times }) => times[0])), end = Math.max(...tracks.map(({ times }) => times.at(-1)));
  return { clip: new THREE.AnimationClip(clip.name, -1, tracks), start: start + first / clip.fps, end };
}

const worst = { animations: 0, poses: 0 }, count = { animations: 0, poses: 0 };
for (const clip of dataset.clips) {
  const controls = npy(clip.controls), [frames, width] = controls.shape;
  const animation = animationOf(clip);
  reset();  // once: a mixer sets what has changed since its last frame
  const mixer = new THREE.AnimationMixer(gltf.scene);
  const action = animation && mixer.clipAction(animation.clip);
  for (let k = 0; k < Math.min(frames, Number(perClip)); ++k) {
    const frame = Math.round(k * (frames - 1) / Math.max(1, Math.min(frames, Number(perClip)) - 1));
    const kind = animation ? "animations" : "poses";
    if (animation) {
      action.setLoop(THREE.LoopOnce);
      action.clampWhenFinished = true;
      action.reset().play();
      mixer.setTime(Math.min(animation.start + frame / clip.fps, animation.end));
    } else if (!setControls(controls.values.subarray(frame * width, (frame + 1) * width))) {
      continue;
    }
    worst[kind] = Math.max(worst[kind], distance(clip, frame));
    ++count[kind];
  }
  mixer.stopAllAction();
  mixer.uncacheRoot(gltf.scene);
}
const name = path.basename(file), limit = 1e-5;
console.log(`${name}: ${json.asset.generator ?? "unknown exporter"}; ${shown.length} primitives, ${vertices.reduce(
  (sum, { object }) => sum + object.geometry.attributes.position.count, 0)} vertices, ${dataset.controls.length} controls`);
console.log(`${name}: ${count.animations} frames of animations differ from three.js by at most ${worst.animations.toExponential(1)}` +
  ` of the diagonal, ${count.poses} other poses by ${worst.poses.toExponential(1)}`);
assert.ok(count.animations + count.poses > 0, "nothing could be compared");
assert.ok(Math.max(worst.animations, worst.poses) <= limit, `the difference is more than ${limit} of the diagonal`);

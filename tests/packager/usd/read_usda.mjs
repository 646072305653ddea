// Reads an exported .usda by three.js' USD loader and its parser, and compares it with a point cache of the same clip:
//   node read_usda.mjs CLIP.usda CLIP.mdd
// The loader makes meshes of the first frame. It does not play points over time: the samples are taken from its parser.
import assert from "node:assert/strict";
import fs from "node:fs";
import * as THREE from "three";
import { USDLoader } from "three/addons/loaders/USDLoader.js";
import { USDAParser } from "three/addons/loaders/usd/USDAParser.js";

const [usda, mdd] = process.argv.slice(2);
const text = fs.readFileSync(usda, "utf8"), cache = fs.readFileSync(mdd);
const frames = cache.readInt32BE(0), points = cache.readInt32BE(4);
const expected = (frame, coordinate) => cache.readFloatBE(8 + 4 * frames + 4 * (frame * 3 * points + coordinate));

// The scene: every corner of a triangle is a point of the first frame, and each point that has a polygon is there.
const scene = new USDLoader().parse(text);
scene.updateMatrixWorld(true);
const meshes = [];
scene.traverse((object) => object.isMesh && meshes.push(object));
assert.ok(meshes.length > 0, "there are no meshes");
const key = (x, y, z) => [x, y, z].map(Math.fround).join(" ");
const shown = new Set();
let triangles = 0;
for (const { geometry } of meshes) {
  const position = geometry.getAttribute("position");
  for (let v = 0; v < position.count; ++v) shown.add(key(position.getX(v), position.getY(v), position.getZ(v)));
  triangles += (geometry.index ? geometry.index.count : position.count) / 3;
  const uv = geometry.getAttribute("uv");
  for (let v = 0; uv && v < uv.count; ++v) assert.ok(Number.isFinite(uv.getX(v)) && Number.isFinite(uv.getY(v)));
}
const first = new Set();
for (let v = 0; v < points; ++v) first.add(key(expected(0, 3 * v), expected(0, 3 * v + 1), expected(0, 3 * v + 2)));
for (const point of shown) assert.ok(first.has(point), `the loader shows a point at ${point} that is none of the face's`);

// The file: points over time, mesh after mesh.
const { specsByPath } = new USDAParser().parseData(text);
const root = specsByPath["/"].fields;
const paths = Object.keys(specsByPath).filter((path) => specsByPath[path].fields.typeName === "Mesh");
let before = 0, polygons = 0, drawn = 0;
const used = new Set();
for (const path of paths) {
  const samples = specsByPath[`${path}.points`].fields;
  assert.deepEqual(samples.timeSamples.times, [...Array(frames).keys()]);
  const size = samples.timeSamples.values[0].length;
  samples.timeSamples.values.forEach((values, frame) => {
    assert.equal(values.length, size);
    values.forEach((number, i) => assert.equal(Math.fround(number), expected(frame, 3 * before + i), `${path}, frame ${frame}`));
  });
  samples.default.forEach((number, i) => assert.equal(Math.fround(number), expected(0, 3 * before + i)));
  const counts = specsByPath[`${path}.faceVertexCounts`].fields.default;
  const corners = specsByPath[`${path}.faceVertexIndices`].fields.default;
  assert.equal(corners.length, counts.reduce((sum, count) => sum + count, 0));
  for (const corner of corners) {
    assert.ok(corner >= 0 && 3 * corner < size);
    used.add(key(...[0, 1, 2].map((k) => expected(0, 3 * (before + corner) + k))));
  }
  const st = specsByPath[`${path}.primvars:st`], indices = specsByPath[`${path}.primvars:st:indices`];
  if (st) {
    assert.equal(indices.fields.default.length, corners.length);
    for (const index of indices.fields.default) assert.ok(2 * index < st.fields.default.length);
  }
  polygons += counts.length;
  drawn += corners.length - 2 * counts.length;
  before += size / 3;
}
assert.equal(before, points);
assert.equal(triangles, drawn);
for (const point of used) assert.ok(shown.has(point), `the loader leaves out the point at ${point}`);
console.log(`${usda}: ${meshes.length} meshes, ${polygons} polygons, ${points} points in ${frames} frames at ` +
  `${root.timeCodesPerSecond} a second, ${root.metersPerUnit} m a unit, ${root.upAxis} up: as in ${mdd}`);

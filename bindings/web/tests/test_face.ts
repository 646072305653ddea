// Faces of the npm package beside what same bits say: contents, errors, memory.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import { FaceBakerError, load } from "facebaker";
import { FaceBakerMesh } from "facebaker/three";
import { Vector3 } from "three";
import { frame } from "./frame_matrix.js";

const golden = process.env["FB_GOLDEN"]!;
const open = (name: string) => load(`${golden}/accepted/${name}.fbk`);
const collect = (globalThis as { gc?: () => void }).gc!;

test("contents are those of the archive", async () => {
  const face = await open("character");
  assert.deepEqual(face.meshes.map(({ name }) => name), ["head", "teeth"]);
  assert.equal(face.meshes.reduce((sum, mesh) => sum + mesh.vertexCount, 0), face.vertexCount);
  assert.equal(face.controls[0]!.name, "jaw_open");
  assert.equal(face.controls[0]!.arkit, "jawOpen");
  assert.equal(face.controls.length, face.controlCount);
  assert.equal(face.findControl("jawOpen"), 0);
  assert.equal(face.findControl(0x251683c4c174b423n), 0); // jaw_open, as facebaker header writes it
  const opened = face.createPose(), { minimum, maximum } = face.controls[0]!;
  opened[0] = maximum;
  assert.equal(face.blend(face.createPose(), opened, 0.5)[0], Math.fround((face.restControls[0]! + maximum) / 2));
  assert.equal(face.blend(opened, face.createPose(), 100)[0], minimum);
  const partner = face.controls.findIndex(({ mirror }) => mirror >= 0), other = face.controls[partner]!.mirror;
  opened[partner] = face.controls[partner]!.maximum;
  assert.equal(face.blend(opened, null, 1, opened), opened);
  assert.equal(opened[other], face.controls[other]!.maximum);
  assert.equal(face.materials[0]!.name, "skin");
  assert.equal(face.materials[0]!.alphaMode, "mask");
  assert(face.images.length > 0 && face.images[0]!.bytes.length > 0);
  assert(face.sockets.length > 0 && face.sockets[0]!.vertices.length >= 3);
  assert(face.diagonal > 0 && face.runtimeBytes > 0);
  for (const mesh of face.meshes)
    for (const vertex of mesh.triangles)
      assert(vertex >= mesh.firstVertex && vertex < mesh.firstVertex + mesh.vertexCount);
  assert.doesNotThrow(() => structuredClone(face.contents()));
  face.dispose();
});

test("levels of detail, channels and exact poses", async () => {
  const levels = await open("levels"), exact = await open("exact-poses"), body = await open("body");
  assert(levels.levels.length > 1);
  const controls = levels.createPose().fill(0.5), coarse = levels.levels[1]!;
  const whole = levels.evaluateInto(controls, { positions: new Float32Array(3 * levels.vertexCount), lod: 1,
                                                vertexOrder: "baked" });
  const alone = levels.evaluateInto(controls, { positions: new Float32Array(3 * coarse.vertexCount), lod: 1,
                                                vertexOrder: "baked", levelOnly: true });
  assert.deepEqual(alone.positions, whole.positions.slice(0, 3 * coarse.vertexCount));
  assert(exact.exactPoses.length > 0);
  assert.equal(exact.exactPoses[0]!.controls.length, exact.controlCount);
  assert(body.joints.length > 0 && body.skin !== null);
  for (const face of [levels, exact, body]) face.dispose();
});

test("meshes that are left out are left as they are", async () => {
  const face = await open("character"), controls = face.createPose().fill(1);
  const { positions } = face.evaluateInto(controls, { positions: new Float32Array(3 * face.vertexCount).fill(7),
                                                      meshes: [1] });
  const all = face.evaluate(controls), first = 3 * face.meshes[1]!.firstVertex;
  assert(positions.subarray(0, first).every((value) => value === 7));
  assert.deepEqual(positions.slice(first), all.slice(first));
  face.dispose();
});

test("controls and arrays that are wrong are refused", async () => {
  const face = await open("tiny"), controls = face.createPose();
  assert.throws(() => face.findControl("jaw_opem"),
                (error: FaceBakerError) => error.statusName === "FB_ERROR_NOT_FOUND" && /jaw_open/.test(error.message));
  assert.throws(() => face.findControl(42n),
                (error: FaceBakerError) => error.statusName === "FB_ERROR_NOT_FOUND" && /000000000000002a/.test(error.message));
  controls[0] = NaN;
  assert.throws(() => face.evaluate(controls), (error: FaceBakerError) => /jaw_open/.test(error.message));
  assert.throws(() => face.blend(controls, null, 0.5), (error: FaceBakerError) => /jaw_open/.test(error.message));
  assert.throws(() => face.blend(new Float32Array(1), null, 0.5), /a pose of 1 numbers/);
  controls[0] = 1e9;
  face.evaluate(controls);
  assert.equal(face.clampedCount, 1);
  assert.throws(() => face.evaluate(new Float32Array(1)), /controls: 1 numbers/);
  assert.throws(() => face.evaluate(controls, new Float32Array(1)), /positions: 1 numbers/);
  assert.throws(() => face.evaluateInto(controls, { normals: new Float32Array(1) }), /normals: 1 numbers/);
  assert.throws(() => face.evaluateInto(controls, { positions: new Float32Array(3 * face.vertexCount), lod: -1 }),
                FaceBakerError);
  face.dispose();
  face.dispose();
  assert.throws(() => face.evaluate(controls), /disposed/);
});

test("vertices follow the driven joints from where they are before", async () => {
  const face = await open("../../2.1/accepted/driven"), { drivenJoints, drivenSkin, vertexCount } = face;
  assert(drivenJoints.length > 1 && drivenSkin !== null);
  drivenJoints.forEach(({ name, parent, numbers, rest }, index) => {
    assert(name !== "" && parent >= -1 && parent < index && rest.length === 12);
    assert(numbers.every((number) => /^(rotate|move|scale|pivot)[XYZ]$/.test(number)));
  });
  assert.deepEqual(drivenJoints.at(-1)!.numbers.slice(9), ["pivotX", "pivotY", "pivotZ"]);
  assert.deepEqual(drivenJoints.map(({ outerRotations }) => outerRotations), [0, 0, 0, 2]);
  assert(drivenJoints.some(({ parent }) => parent >= 0) && drivenJoints.some(({ numbers }) => numbers.length > 1));
  assert.deepEqual((await open("character")).drivenJoints, []);
  assert.equal((await open("character")).drivenSkin, null);

  const controls = face.createPose(), places = () => ({ joints: new Float32Array(12 * drivenJoints.length) });
  assert.deepEqual(Array.from(face.evaluateInto(controls, places()).joints), drivenJoints.flatMap(({ rest }) => rest));
  controls.set(face.controls.map(({ minimum, maximum }) => minimum + 0.7 * (maximum - minimum)));
  const unskinned = { positions: new Float32Array(3 * vertexCount), unskinned: true };
  const before = face.evaluateInto(controls, { ...unskinned, ...places() });
  const after = face.evaluate(controls), { influences, joints, weights } = drivenSkin;
  assert.deepEqual(face.evaluateInto(controls, { ...places(), meshes: [] }).joints, before.joints);
  const moves = drivenJoints.map(({ rest }, joint) => frame(before.joints, 12 * joint).multiply(frame(rest).invert()));
  let furthest = 0;
  for (let v = 0; v < vertexCount; ++v) {
    const from = new Vector3().fromArray(before.positions, 3 * v), to = from.clone();
    for (let i = influences * v; i < influences * (v + 1); ++i)
      to.addScaledVector(from.clone().applyMatrix4(moves[joints[i]!]!).sub(from), weights[i]!);
    assert(to.distanceTo(new Vector3().fromArray(after, 3 * v)) < 1e-6 * face.diagonal, `vertex ${v}`);
    furthest = Math.max(furthest, to.distanceTo(from));
  }
  assert(furthest > 0.01 * face.diagonal, `joints move vertices by ${furthest}`);
  face.dispose();
});

test("row blocks times coefficients are the displacements", async () => {
  for (const name of ["character", "regular", "rows-5", "../../2.1/accepted/driven"]) {
    const face = await open(name), controls = face.createPose().fill(0.8), order = face.vertexOrder;
    const coefficients = face.coefficients(controls);
    const { positions: expected } = face.evaluateInto(controls, { positions: new Float32Array(3 * face.vertexCount),
                                                                  unskinned: true });
    const moved = Float64Array.from(face.restPositions);
    let rows = 0;
    for (const { firstRow, rowCount, columns, scales, digits } of face.rowBlocks) {
      assert.equal(firstRow, rows);
      rows += rowCount;
      columns.forEach((column, c) => {
        for (let r = 0; r < rowCount; ++r) {
          const row = firstRow + r, vertex = order ? order[Math.floor(row / 3)]! : Math.floor(row / 3);
          moved[3 * vertex + (row % 3)]! += coefficients[column]! * scales[c]! * digits[c * rowCount + r]!;
        }
      });
    }
    assert.equal(rows, 3 * face.vertexCount);
    for (let i = 0; i < moved.length; ++i) assert(Math.abs(moved[i]! - expected[i]!) < 1e-3, `${name}: ${i}`);
    face.dispose();
  }
});

test("progress, limits and aborting", async () => {
  const calls: [number, number][] = [];
  (await load(`${golden}/accepted/tiny.fbk`, { progress: (...of) => calls.push(of) })).dispose();
  assert.deepEqual(calls.at(-1)![0], calls.at(-1)![1]);
  await assert.rejects(load(`${golden}/accepted/tiny.fbk`, { limits: { vertices: 3 } }),
                       (error: FaceBakerError) => error.statusName === "FB_ERROR_LIMIT");
  await assert.rejects(load(`${golden}/accepted/tiny.fbk`, { signal: AbortSignal.abort() }), { name: "AbortError" });
});

test("a thousand faces that are disposed of take no memory", async () => {
  const bytes = readFileSync(`${golden}/accepted/character.fbk`);
  const wasm = readFileSync(new URL("../dist/facebaker.wasm", import.meta.url)); // an instance of its own
  const use = async () => {
    const face = await load(bytes, { wasm });
    face.evaluate(face.createPose());
    void face.contents();
    const { buffer } = face.evaluateInPlace(face.createPose());
    face.dispose();
    return buffer.byteLength;
  };
  for (let i = 0; i < 20; ++i) await use();
  const before = await use();
  for (let i = 0; i < 1000; ++i) await use();
  assert.equal(await use(), before);
});

// A scratch takes 1.5 kB for this face, 0.5 MB for the quickstart's; one for batches ten times as much.
test("characters take no memory of the module, and faces no room for batches", async () => {
  const bytes = readFileSync(`${golden}/accepted/character.fbk`);
  const wasm = readFileSync(new URL("../dist/facebaker.wasm", import.meta.url)); // an instance of its own
  const face = await load(bytes, { wasm }), controls = face.createPose(), count = 2000;
  const size = () => face.evaluateInPlace(controls).buffer.byteLength;
  const outputs = () => ({ positions: new Float32Array(3 * face.vertexCount), normals: new Float32Array(3 * face.vertexCount) });
  face.evaluateInto(controls, outputs());
  const before = size();
  const characters = Array.from({ length: count }, () => new FaceBakerMesh(face));
  face.evaluateMany(characters.map((_, index) => ({ controls, outputs: { ...outputs(), lod: index % 2 } })));
  assert.equal(size(), before);

  const faces = await Promise.all(Array.from({ length: count / 2 }, () => load(bytes, { wasm })));
  for (const other of faces) other.evaluateInto(controls, outputs());
  const each = (size() - before) / faces.length - face.runtimeBytes;
  for (const other of faces) other.evaluateBatch(new Float32Array(2 * face.controlCount), 2,
                                                 { bounds: new Float32Array(12) });
  const batches = (size() - before) / faces.length - face.runtimeBytes - each;
  assert(each < 12000 && batches > 12000, `${each} bytes a face beside its model, ${batches} more for batches`);
});

test("faces of several sizes take turns", async () => {
  const faces = await Promise.all(["tiny", "character", "levels", "tiny"].map(open));
  const poses = faces.map((face) => face.createPose().fill(0.6));
  const expected = faces.map((face, i) => face.evaluate(poses[i]!));
  for (let round = 0; round < 2; ++round)
    faces.forEach((face, i) => {
      assert.deepEqual(face.evaluate(poses[i]!), expected[i]);
      const bounds = new Float32Array(6), two = new Float32Array(2 * poses[i]!.length).fill(0.6);
      assert.deepEqual(face.evaluateInto(poses[i]!, { positions: new Float32Array(expected[i]!.length), bounds }).positions,
                       expected[i]);
      const both = face.evaluateBatch(two, 2, { positions: new Float32Array(2 * expected[i]!.length) }).positions;
      assert.deepEqual(both.subarray(expected[i]!.length), expected[i]);
    });
  faces[1]!.dispose();
  assert.deepEqual(faces[0]!.evaluate(poses[0]!), expected[0]);
  for (const face of faces) face.dispose();
});

test("posing into given arrays allocates nothing", async () => {
  const face = await open("character"), controls = face.createPose(), positions = new Float32Array(3 * face.vertexCount);
  const outputs = { positions, normals: new Float32Array(3 * face.vertexCount), bounds: new Float32Array(6) };
  const poses = 100000;
  const bytesOf = (pose: (i: number) => void) => {
    for (let i = 0; i < poses; ++i) pose(i); // compiled by now
    collect();
    const before = process.memoryUsage().heapUsed;
    for (let i = 0; i < poses; ++i) pose(i);
    return (process.memoryUsage().heapUsed - before) / poses;
  };
  const one = bytesOf((i) => {
    controls[0] = (i % 100) / 100;
    face.evaluate(controls, positions);
  });
  const all = bytesOf((i) => {
    controls[0] = (i % 100) / 100;
    face.evaluateInto(controls, outputs);
  });
  // The least object takes 12 bytes; the engine itself takes some 100 kB now and then.
  assert(one < 4, `${one} bytes a pose`);
  assert(all < 4, `${all} bytes a pose with normals and bounds`);
  face.dispose();
});

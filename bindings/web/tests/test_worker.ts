// Faces in workers give what faces here give.
import assert from "node:assert/strict";
import test from "node:test";
import { FaceBakerError, load } from "facebaker";
import { load as loadInWorker } from "facebaker/worker";

const golden = process.env["FB_GOLDEN"]!, path = `${golden}/accepted/character.fbk`;

test("a worker poses, and buffers come back", async () => {
  const here = await load(path), there = await loadInWorker(path), controls = here.createPose().fill(0.7);
  assert.deepEqual(there.contents, here.contents());
  const mine = new Float32Array(3 * there.vertexCount), { buffer } = mine;
  const positions = await there.evaluate(controls, mine);
  assert.equal(buffer.byteLength, 0); // moved, not copied
  assert.deepEqual(positions, here.evaluate(controls));
  assert.equal(controls.length, here.controlCount); // copied
  const normals = () => ({ positions: new Float32Array(3 * here.vertexCount), normals: new Float32Array(3 * here.vertexCount) });
  assert.deepEqual(await there.evaluateInto(controls, normals()), here.evaluateInto(controls, normals()));
  assert.deepEqual(await there.coefficients(controls), here.coefficients(controls));
  assert.deepEqual(await there.rowBlocks(), here.rowBlocks);
  const order = await Promise.all([0, 0.5, 1].map((value) => there.evaluate(there.createPose().fill(value))));
  order.forEach((found, i) => assert.deepEqual(found, here.evaluate(here.createPose().fill(i / 2))));
  await there.dispose();
  await assert.rejects(there.evaluate(controls));
  here.dispose();
});

test("a worker poses many characters by one message", async () => {
  const archive = `${golden}/accepted/levels.fbk`, here = await load(archive), there = await loadInWorker(archive);
  const pose = (value: number, lod: number) => ({
    controls: here.createPose().fill(value),
    outputs: { lod, positions: new Float32Array(3 * here.vertexCount), bounds: new Float32Array(6) },
  });
  const given = [pose(0.2, 0), pose(0.4, 1), pose(0.6, 1.5)];
  const found = await there.evaluateMany(given);
  assert.equal(given[0]!.outputs.positions.length, 0); // moved, not copied
  assert.equal(given[0]!.controls.length, here.controlCount); // copied
  found.forEach((outputs, i) => {
    const { controls, outputs: mine } = pose(0.2 * (i + 1), [0, 1, 1.5][i]!);
    assert.deepEqual(outputs, here.evaluateInto(controls, mine));
  });
  const broken = [pose(0, 0), pose(NaN, 0)];
  assert.throws(() => here.evaluateMany(broken), /^FaceBakerError: character 1: .*jaw_open/);
  await assert.rejects(there.evaluateMany(broken), /^FaceBakerError: character 1: .*jaw_open/);
  await there.dispose();
  here.dispose();
});

test("a worker has the driven joints and gives their frames", async () => {
  const archive = `${golden}/../2.1/accepted/driven.fbk`;
  const here = await load(archive), there = await loadInWorker(archive), controls = here.createPose().fill(0.7);
  assert.deepEqual(there.contents, here.contents());
  const outputs = () => ({ joints: new Float32Array(12 * here.drivenJoints.length),
                           positions: new Float32Array(3 * here.vertexCount), unskinned: true });
  const mine = outputs(), found = await there.evaluateInto(controls, mine);
  assert.equal(mine.joints.length, 0); // moved, not copied
  assert.deepEqual(found, here.evaluateInto(controls, outputs()));
  await there.dispose();
  here.dispose();
});

test("a worker's errors arrive", async () => {
  await assert.rejects(loadInWorker(new Uint8Array(100)),
                       (error: FaceBakerError) => error instanceof FaceBakerError && error.statusName === "FB_ERROR_NOT_AN_ARCHIVE");
  const face = await loadInWorker(path), controls = face.createPose();
  controls[0] = NaN;
  await assert.rejects(face.evaluate(controls), (error: FaceBakerError) => error.statusName === "FB_ERROR_NOT_FINITE");
  await face.dispose();
});

test("a control that is not there is refused in a worker's words as here", async () => {
  const here = await load(path), there = await loadInWorker(path);
  const refusal = (face: { findControl(name: string): number }, name: string): string => {
    try {
      return String(face.findControl(name));
    } catch (error) {
      assert(error instanceof FaceBakerError && error.statusName === "FB_ERROR_NOT_FOUND");
      return error.message;
    }
  };
  const names = ["", "nothing", "Öffnen", ...here.controls.flatMap(({ name }) => [`${name}x`, name.slice(1), name.toUpperCase()])];
  for (const name of names) assert.equal(refusal(there, name), refusal(here, name));
  assert(names.some((name) => name && refusal(there, name).includes(`the closest is "${here.controls[0]!.name}"`)));
  await there.dispose();
  here.dispose();
});

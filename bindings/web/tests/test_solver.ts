// Solving and derivatives have the bits of the native library, with SIMD and without; what is wrong is refused.
//   FB_SOLVES: a list of ARCHIVE=DUMP of native_solves.c, separated by blanks
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import { load } from "facebaker";
import { FaceBakerError, loadSolver, type SolveTargets, type Solver } from "facebaker/solver";
import { firstDifference } from "./expected_poses.js";
import { readExpectedSolves } from "./expected_solves.js";

const golden = process.env["FB_GOLDEN"]!, character = `${golden}/accepted/character.fbk`;
const pairs = (process.env["FB_SOLVES"] ?? "").split(" ").filter(Boolean).map((pair) => pair.split("="));
assert(pairs.length > 0, "FB_SOLVES names no archives");

const readDump = (path: string) => {
  const bytes = readFileSync(path);
  return readExpectedSolves(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer);
};

function checkSame(what: string, found: Float32Array, expected: Float32Array): void {
  const at = firstDifference(found, expected);
  assert(at < 0, `${what}: number ${at} is ${found[at]}, expected ${expected[at]}`);
}

function checkSparse(solver: Solver, pose: Float32Array, dense: Float32Array): void {
  const { starts, rows, values } = solver.sparseJacobian(pose), columns = solver.controlCount;
  const filled = new Float32Array(dense.length);
  for (let c = 0; c < columns; ++c)
    for (let entry = starts[c]!; entry < starts[c + 1]!; ++entry) filled[rows[entry]! * columns + c] = values[entry]!;
  assert.deepEqual(filled.map((value) => value + 0), dense.map((value) => value + 0)); // 0 and -0 alike
}

let points = 0, frames = 0;
for (const [archive, dump] of pairs as [string, string][])
  for (const simd of [true, false])
    test(`solves ${archive.replace(/.*\//, "")} ${simd ? "with SIMD" : "without SIMD"}`, async () => {
      const { vertices, sockets, joints, solves } = readDump(dump), solver = await loadSolver(archive, { simd });
      const upTo = (count: number) => Array.from({ length: count }, (_, i) => i);
      solver.follow({ vertices, sockets: upTo(sockets), joints: upTo(joints) });
      const controls = solver.createPose(), decided = new Float32Array(controls.length);
      const pointDifferences = new Float32Array(solver.pointCount), movable = controls.map((_, i) => (i % 3 ? 1 : 0));
      for (const [i, expected] of solves.entries()) {
        checkSame(`values of pose ${i}`, solver.values(expected.pose), expected.values);
        checkSame(`derivatives of pose ${i}`, solver.jacobian(expected.pose), expected.derivatives);
        checkSparse(solver, expected.pose, expected.derivatives);
        const before = controls.slice(), targets: SolveTargets = { points: expected.values, decided, pointDifferences };
        if (i % 2 === 1)
          Object.assign(targets, { symmetry: 0.5, sparsity: 0, smoothness: 0.25, near: before, before,
                                   movable: Uint8Array.from(movable) });
        const found = solver.solve(controls, targets);
        checkSame(`controls of solve ${i}`, controls, expected.found);
        checkSame(`what decides solve ${i}`, decided, expected.decided);
        checkSame(`differences of solve ${i}`, pointDifferences, expected.differences);
        assert.deepEqual([found.iterations, Number(found.converged), found.pointCount, found.worstPoint], expected.counts);
        assert.deepEqual([found.rmsDifference, found.maxDifference], expected.distances);
        assert.equal(found.objective, expected.objective);
      }
      points += solver.pointCount;
      frames += solver.frameCount;
      solver.dispose();
    });

test("points and frames were followed", () => assert(points > 0 && frames > 0));

test("weights, distances and chosen controls", async () => {
  const solver = await loadSolver(readFileSync(character)), face = await load(character);
  solver.follow({ vertices: [3, 7, 11, 20, 20, 0], weights: [0.5, 0.25, 0.25, 1, 0, 0], pairs: [0, 1] });
  assert.deepEqual([solver.pointCount, solver.pairCount, solver.rowCount], [2, 1, 6]);
  const pose = solver.createPose().map((value, i) => (i === 0 ? 0.5 : value)), values = solver.values(pose);
  const positions = face.evaluate(pose);
  for (const axis of [0, 1, 2]) {
    const mean = [3, 7, 11].reduce((sum, vertex, i) => sum + positions[3 * vertex + axis]! * [0.5, 0.25, 0.25][i]!, 0);
    assert(Math.abs(values[axis]! - mean) < 1e-5 * face.diagonal);
  }
  const all = solver.jacobian(pose), one = solver.jacobian(pose, { chosen: [solver.findControl("jawOpen")] });
  assert.deepEqual([...one], [...all].filter((_, i) => i % solver.controlCount === 0));
  const gap = Math.hypot(values[0]! - values[3]!, values[1]! - values[4]!, values[2]! - values[5]!);
  const controls = solver.createPose();
  const found = solver.solve(controls, { distances: Float32Array.of(gap), sparsity: 0, nearness: 0 });
  assert.equal(found.pointCount, 0);
  assert(controls.some((value, i) => value !== face.restControls[i]));
  solver.dispose();
  assert.throws(() => solver.follow(), /disposed of/);
  face.dispose();
});

test("where the head is, is found too", async () => {
  const solver = await loadSolver(character), controls = solver.createPose(), motion = new Float32Array(12);
  const moved = solver.values(controls).map((value, i) => 2 * value + (i % 3 === 0 ? 7 : 0));
  solver.solve(controls, { points: moved, motion, toFace: Float32Array.of(0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0) });
  const expected = [1, 0, 0, 3.5, 0, 1, 0, 0, 0, 0, 1, 0];
  motion.forEach((value, i) => assert(Math.abs(value - expected[i]!) < 1e-3, `${i}: ${value}`));
  solver.dispose();
});

test("what is wrong is refused by name", async () => {
  const solver = await loadSolver(character), controls = solver.createPose();
  assert.throws(() => solver.follow({ vertices: [1e6] }),
                (error: FaceBakerError) => error.statusName === "FB_ERROR_INVALID_ARGUMENT" && /1000000/.test(error.message));
  assert.throws(() => solver.solve(controls, { points: new Float32Array(5) }), /points: 5 numbers, but \d+ are needed/);
  assert.throws(() => solver.solve(controls.slice(1), {}), /controls: \d+ numbers, but \d+ are needed/);
  assert.throws(() => solver.solve(controls, { nearness: -1 }), /nearness/);
  const points = solver.values(controls).fill(Infinity, 4, 5);
  assert.throws(() => solver.solve(controls, { points }),
                (error: FaceBakerError) => error.statusName === "FB_ERROR_NOT_FINITE" && /1/.test(error.message));
  await assert.rejects(loadSolver(readFileSync(character).subarray(0, 200)), FaceBakerError);
  await assert.rejects(loadSolver(character, { limits: { vertices: 2 } }), /vert/);
  solver.dispose();
});

// What the page of every bundler does: a face here and one in a worker give the same positions, and the solver has them too.
import { load } from "facebaker";
import { load as loadInWorker } from "facebaker/worker";
import { loadSolver } from "facebaker/solver";
import { renderMeshes } from "facebaker/geometry";
import { FaceBakerMesh } from "facebaker/three";

export async function checkFace(address) {
  const here = await load(address), far = await loadInWorker(address);
  const controls = here.createPose().fill(0.5);
  const expected = here.evaluate(controls), found = await far.evaluate(controls);
  if (found.some((value, i) => value !== expected[i])) throw new Error("the worker gives other positions");
  if (!found.some((value, i) => value !== here.restPositions[i])) throw new Error("the face does not move");
  const solver = await loadSolver(address), values = solver.values(controls);
  if (values.some((value, i) => Math.abs(value - expected[i]) > 1e-4 * here.diagonal)) throw new Error("the solver has other positions");
  solver.dispose();
  if (new FaceBakerMesh(here).meshes.length !== renderMeshes(here).length) throw new Error("a mesh is missing");
  await far.dispose();
  return { vertices: here.vertexCount };
}

/** Tells tests/browser/check_bundled.ts how it went. */
export function report(address) {
  checkFace(address).then((result) => { globalThis.facebakerResult = result; },
                          (error) => { globalThis.facebakerResult = { error: String(error) }; });
}

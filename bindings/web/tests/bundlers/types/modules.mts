// As ES modules; three-webgpu is for these alone.
import { load, FaceBakerError, type Face } from "facebaker";
import { load as loadInWorker, type WorkerFace } from "facebaker/worker";
import { loadSolver, type Solver } from "facebaker/solver";
import { renderMeshes } from "facebaker/geometry";
import { FaceBakerMesh } from "facebaker/three";
import type { GpuEvaluator } from "facebaker/webgpu";
import type { FaceBakerNodeMesh } from "facebaker/three-webgpu";

export type Gpu = FaceBakerNodeMesh | GpuEvaluator;

export async function run(path: string): Promise<string> {
  const face: Face = await load(path), far: WorkerFace = await loadInWorker(path);
  const here = face.evaluate(face.createPose()), there = await far.evaluate(far.createPose());
  if (here.some((value, i) => value !== there[i])) throw new Error("other positions");
  const solver: Solver = await loadSolver(path);
  if (solver.values(solver.createPose()).length !== here.length) throw new Error("other points");
  solver.dispose();
  const { meshes } = new FaceBakerMesh(face);
  if (renderMeshes(face).length !== meshes.length) throw new Error("a mesh is missing");
  await far.dispose();
  await load(`${path}.none`).then(() => { throw new Error("loaded"); }, (error: unknown) => {
    if (!(error instanceof FaceBakerError)) throw error;
  });
  return `${face.vertexCount} vertices`;
}

run(process.argv[2]!).then((text) => console.log(`ES modules: ${text}`), (error) => { console.error(error); process.exitCode = 1; });

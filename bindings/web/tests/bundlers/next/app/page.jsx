import { load } from "facebaker";
import { load as loadInWorker } from "facebaker/worker";
import { InBrowser } from "./in_browser";

// The server poses the face, by Node, and hands the page what it found.
export default async function Page() {
  const face = await load("public/face.fbk"), far = await loadInWorker("public/face.fbk");
  const controls = face.createPose().fill(0.5), here = face.evaluate(controls), there = await far.evaluate(controls);
  if (there.some((value, i) => value !== here[i])) throw new Error("the worker gives other positions");
  await far.dispose();
  return <InBrowser vertices={face.vertexCount} />;
}

import { load } from "facebaker";
import { load as loadInWorker } from "facebaker/worker";
import { InBrowser } from "./in_browser";

// The server poses the face, by Node, and writes what it found into the page.
export default async function Page() {
  const face = await load("public/face.fbk"), far = await loadInWorker("public/face.fbk");
  const controls = face.createPose().fill(0.5), here = face.evaluate(controls), there = await far.evaluate(controls);
  if (there.some((value, i) => value !== here[i])) throw new Error("the worker gives other positions");
  await far.dispose();
  return (
    <>
      <p id="server">{face.vertexCount}</p>
      <InBrowser />
    </>
  );
}

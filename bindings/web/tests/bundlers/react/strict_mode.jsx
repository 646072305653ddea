// A face in a component of React. In development StrictMode mounts it, unmounts it and mounts it again: it has to be in its
// scene and to be drawn after that, and again after it was taken away and brought back.
import { StrictMode, useEffect, useMemo, useRef, useState } from "react";
import { createRoot } from "react-dom/client";
import { AmbientLight, Box3, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { load } from "facebaker";
import { FaceBakerMesh } from "facebaker/three";
import { checkFace } from "./check_face.js";

let mounts = 0, disposals = 0;
let drawing = null; // what is mounted

function makeStage(face) {
  const scene = new Scene(), mesh = new FaceBakerMesh(face), camera = new PerspectiveCamera(30, 1, 0.01 * face.diagonal, 10 * face.diagonal);
  scene.add(mesh, new AmbientLight(0xffffff, 3));
  camera.position.copy(new Box3().setFromObject(mesh).getCenter(new Vector3())).add(new Vector3(0, 0, 2 * face.diagonal));
  return { scene, mesh, camera };
}

function Face({ face }) {
  const canvas = useRef(null), stage = useMemo(() => makeStage(face), [face]);
  useEffect(() => {
    const renderer = new WebGLRenderer({ canvas: canvas.current, alpha: true, preserveDrawingBuffer: true });
    stage.mesh.update(face.createPose().fill(0.5));
    drawing = { ...stage, renderer };
    ++mounts;
    return () => {
      ++disposals;
      drawing = null;
      stage.mesh.dispose();
      renderer.dispose();
    };
  }, [face, stage]);
  return <canvas ref={canvas} width="300" height="300" />;
}

let show;

function App({ face }) {
  const [shown, setShown] = useState(true);
  show = setShown;
  return shown ? <Face face={face} /> : null;
}

// Pixels that are not background, in the next picture.
async function countDrawn() {
  await new Promise((resolve) => setTimeout(resolve, 500));
  const { renderer, scene, camera, mesh } = drawing;
  if (mesh.parent !== scene) throw new Error("the face is not in its scene any more");
  renderer.render(scene, camera);
  const context = renderer.getContext(), pixels = new Uint8Array(4 * 300 * 300);
  context.readPixels(0, 0, 300, 300, context.RGBA, context.UNSIGNED_BYTE, pixels);
  const count = pixels.reduce((sum, value, i) => sum + (i % 4 === 3 && value > 0 ? 1 : 0), 0);
  if (count < 500) throw new Error(`${count} pixels are drawn`);
  return count;
}

const until = async (done, what) => {
  for (let i = 0; !done(); ++i) {
    if (i === 600) throw new Error(`${what} does not come`);
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
};

async function check() {
  const face = await load("/face.fbk");
  createRoot(document.getElementById("root")).render(<StrictMode><App face={face} /></StrictMode>);
  await until(() => mounts === 2 && disposals === 1, "StrictMode's second mount");
  const first = await countDrawn();
  show(false);
  await until(() => drawing === null, "the empty page");
  show(true);
  await until(() => drawing !== null && mounts === 4, "the face");
  const last = await countDrawn();
  if (last !== first) throw new Error(`${last} pixels are drawn, of ${first}`);
  return checkFace("/face.fbk");
}

check().then((result) => { globalThis.facebakerResult = result; },
             (error) => { globalThis.facebakerResult = { error: String(error) }; });

// A face as a component of @react-three/fiber. StrictMode mounts it, unmounts it and mounts it again: it has to be there
// and to be drawn after that, and again after it was taken away and brought back.
import { StrictMode, useEffect, useMemo, useState } from "react";
import { createRoot } from "react-dom/client";
import { Canvas, useThree } from "@react-three/fiber";
import { load } from "facebaker";
import { FaceBakerMesh } from "facebaker/three";
import { checkFace } from "./check_face.js";

let root; // the store of the canvas
let disposals = 0;

function Face({ face, open }) {
  const mesh = useMemo(() => new FaceBakerMesh(face), [face]);
  useEffect(() => () => {
    ++disposals;
    mesh.dispose();
  }, [mesh]);
  useEffect(() => mesh.update(face.createPose().fill(open)), [mesh, face, open]);
  return <primitive object={mesh} />;
}

function Keep() {
  root = useThree();
  return null;
}

function App({ face }) {
  const [shown, show] = useState(true);
  globalThis.show = show;
  const distance = 2 * face.diagonal;
  return (
    <Canvas gl={{ preserveDrawingBuffer: true }} camera={{ position: [0, 0, distance], near: distance / 100, far: 10 * distance }}>
      <ambientLight intensity={3} />
      <Keep />
      {shown && <Face face={face} open={0.5} />}
    </Canvas>
  );
}

// Pixels that are not background, in the next picture.
async function countDrawn() {
  await new Promise((resolve) => setTimeout(resolve, 500));
  const { gl, scene, camera } = root;
  gl.render(scene, camera);
  const context = gl.getContext(), { drawingBufferWidth: width, drawingBufferHeight: height } = context;
  const pixels = new Uint8Array(4 * width * height);
  context.readPixels(0, 0, width, height, context.RGBA, context.UNSIGNED_BYTE, pixels);
  return pixels.reduce((count, value, i) => count + (i % 4 === 3 && value > 0 ? 1 : 0), 0);
}

const until = async (done, what) => {
  for (let i = 0; !done(); ++i) {
    if (i === 200) throw new Error(`${what} does not come`);
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
};

const inScene = () => root.scene.children.filter((child) => child instanceof FaceBakerMesh).length;

async function check() {
  const face = await load("/face.fbk");
  createRoot(document.getElementById("root")).render(<StrictMode><App face={face} /></StrictMode>);
  await until(() => root?.scene && disposals > 0, "StrictMode's second mount");
  const first = await countDrawn();
  if (inScene() !== 1 || first < 500) throw new Error(`${inScene()} faces in the scene, ${first} pixels drawn`);
  globalThis.show(false);
  await until(() => inScene() === 0, "the empty scene");
  if (await countDrawn() !== 0) throw new Error("a face that was taken away is drawn");
  globalThis.show(true);
  await until(() => inScene() === 1, "the face");
  const last = await countDrawn();
  if (last !== first) throw new Error(`${last} pixels drawn, of ${first}`);
  return checkFace("/face.fbk");
}

check().then((result) => { globalThis.facebakerResult = result; },
             (error) => { globalThis.facebakerResult = { error: String(error) }; });

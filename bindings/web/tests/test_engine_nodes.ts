// What an engine need not draw to show: Babylon.js and PlayCanvas without a window.
import assert from "node:assert/strict";
import test from "node:test";
import { NullEngine } from "@babylonjs/core/Engines/nullEngine.js";
import { VertexBuffer } from "@babylonjs/core/Buffers/buffer.js";
import { Vector3 } from "@babylonjs/core/Maths/math.vector.js";
import { TransformNode } from "@babylonjs/core/Meshes/transformNode.js";
import { Scene } from "@babylonjs/core/scene.js";
import { load, type Face } from "facebaker";
import { FaceBakerNode } from "facebaker/babylon";
import { renderMeshes } from "facebaker/geometry";
import { FaceBakerEntity } from "facebaker/playcanvas";
import { AppBase, AppOptions, Entity, NullGraphicsDevice, RenderComponentSystem, type ComponentSystem, type Mat4 } from "playcanvas";

const golden = process.env["FB_GOLDEN"]!;

/** The face with something else in place of what it has. */
const withOther = (face: Face, other: object): Face =>
  Object.create(face, Object.fromEntries(Object.entries(other).map(([name, value]) => [name, { value }]))) as Face;

test("a face of an unknown unit is not scaled to metres", async () => {
  const face = await load(`${golden}/accepted/character.fbk`), scene = new Scene(new NullEngine());
  const inHeads = withOther(face, { units: "heads" });
  assert.throws(() => new FaceBakerNode(inHeads, scene, { metres: true }), /"heads"/);
  assert.equal(new FaceBakerNode(inHeads, scene).metresPerUnit, null);
  assert.equal(new FaceBakerNode(face, scene).metresPerUnit, 0.01);
  face.dispose();
});

test("a pose fills the buffers that are there, and the box around the mesh", async () => {
  const face = await load(`${golden}/accepted/character.fbk`), scene = new Scene(new NullEngine());
  const node = new FaceBakerNode(face, scene), mesh = node.meshes[0]!, buffer = mesh.getVertexBuffer(VertexBuffer.PositionKind)!;
  const array = buffer.getData(), box = mesh.getBoundingInfo().boundingBox;
  const controls = face.createPose().fill(0.6), n = 3 * face.vertexCount;
  node.update(controls);
  const { positions, bounds } = face.evaluateInto(controls, { positions: new Float32Array(n), bounds: new Float32Array(6) });
  assert.equal(mesh.getVertexBuffer(VertexBuffer.PositionKind), buffer);
  assert.equal(buffer.getData(), array);
  renderMeshes(face)[0]!.source.forEach((from, v) =>
    assert.deepEqual((array as Float32Array).slice(3 * v, 3 * v + 3), positions.slice(3 * from, 3 * from + 3)));
  assert.deepEqual([...box.minimum.asArray(), ...box.maximum.asArray()], Array.from(bounds));
  face.dispose();
});

// Where a skin has the first vertex of each mesh that follows joints, in the world.
function corners(node: FaceBakerNode): Vector3[] {
  node.skeleton!.prepare(true);
  return node.meshes.filter(({ skeleton }) => skeleton).map((mesh) =>
    Vector3.TransformCoordinates(Vector3.FromArray(mesh.getPositionData(true)!), mesh.computeWorldMatrix(true)));
}

test("a node of Babylon.js follows the bones of a body, from where it was put", async () => {
  const face = await load(`${golden}/accepted/body.fbk`);
  for (const rightHanded of [true, false]) {
    const scene = new Scene(new NullEngine()), body = new TransformNode("body", scene);
    scene.useRightHandedSystem = rightHanded;
    const node = new FaceBakerNode(face, scene, { metres: true });
    for (const { name } of face.joints) new TransformNode(name, scene).parent = body;
    for (const joint of body.getChildTransformNodes()) joint.rotation.set(0.3, -1, 2); // axes of its own
    node.position.set(0, 1.6, 0);
    const before = corners(node);
    assert(before.length > 0);
    assert.deepEqual(node.followBones(body), []);
    scene.onBeforeRenderObservable.notifyObservers(scene);
    corners(node).forEach((at, i) => assert(Vector3.Distance(at, before[i]!) < 1e-6, "it jumps"));
    body.rotation.y = 0.7;
    body.position.set(3, 0, 1);
    scene.onBeforeRenderObservable.notifyObservers(scene);
    const step = body.computeWorldMatrix(true);
    corners(node).forEach((at, i) =>
      assert(Vector3.Distance(at, Vector3.TransformCoordinates(before[i]!, step)) < 1e-6, "it stays behind"));
    assert.deepEqual(node.followBones(new TransformNode("nobody", scene)), face.joints.map(({ name }) => name));
    node.dispose();
    scene.onBeforeRenderObservable.notifyObservers(scene); // Babylon.js cleans up in the next frame
    await new Promise((resolve) => setTimeout(resolve));
    assert.equal(scene.onBeforeRenderObservable.observers.length, 0);
  }
  face.dispose();
});

function makeApp(systems: (new (app: AppBase) => ComponentSystem)[]): AppBase {
  const canvas = { getBoundingClientRect: () => ({}), addEventListener() {}, removeEventListener() {} } as unknown as HTMLCanvasElement;
  const app = new AppBase(canvas), options = new AppOptions();
  options.graphicsDevice = new NullGraphicsDevice(canvas);
  options.componentSystems = systems;
  app.init(options);
  return app;
}

test("an application that draws no meshes is told so", async () => {
  const face = await load(`${golden}/accepted/character.fbk`);
  assert.throws(() => new FaceBakerEntity(face, makeApp([])), /RenderComponentSystem/);
  face.dispose();
});

test("an entity's parts are where the pose is", async () => {
  const face = await load(`${golden}/accepted/character.fbk`), entity = new FaceBakerEntity(face, makeApp([RenderComponentSystem]), { metres: true });
  const controls = face.createPose().fill(0.6), { bounds } = face.evaluateInto(controls, { bounds: new Float32Array(6) });
  entity.update(controls);
  const parts = entity.children[0]!.children as Entity[];
  assert.deepEqual(parts.map(({ name }) => name), face.meshes.map(({ name }) => name));
  for (const part of parts)
    for (const { aabb } of part.render!.meshInstances) {
      const found = [...aabb.getMin().toArray(), ...aabb.getMax().toArray()];
      found.forEach((value, i) => assert(Math.abs(value - 0.01 * bounds[i]!) < 1e-6, String(found)));
    }
  face.dispose();
});

test("bones of PlayCanvas follow those of a body, from where they were put", async () => {
  const face = await load(`${golden}/accepted/body.fbk`), app = makeApp([RenderComponentSystem]), body = new Entity("body", app);
  const entity = new FaceBakerEntity(face, app, { metres: true });
  for (const { name } of face.joints.slice(1)) {
    const joint = new Entity(name, app);
    joint.setEulerAngles(20, -50, 100); // axes of its own
    body.addChild(joint);
  }
  entity.setPosition(0, 1.6, 0);
  const worlds = () => entity.bones.map((bone) => bone.getWorldTransform().clone()), before = worlds();
  assert.deepEqual(entity.followBones(body), [face.joints[0]!.name]);
  const near = (found: readonly Mat4[], expected: readonly Mat4[], what: string) => found.forEach((matrix, bone) =>
    matrix.data.forEach((value, i) => assert(Math.abs(value - expected[bone]!.data[i]!) < 1e-6, what)));
  near(worlds(), before, "it jumps");
  body.setPosition(3, 0, 1);
  body.setEulerAngles(0, 40, 0);
  near(worlds(), before.map((world, bone) => bone === 0 ? world : body.getWorldTransform().clone().mul(world)), "it stays behind");
  entity.destroy();
  assert(body.children.every(({ children }) => children.length === 0));
  face.dispose();
});

// Meshes for drawing: triangles, seams, and three.js' geometries.
import assert from "node:assert/strict";
import test from "node:test";
import { load, metresPerUnit, type FaceContents } from "facebaker";
import { renderMeshes, scatter } from "facebaker/geometry";
import { FaceBakerMesh } from "facebaker/three";
import { FaceBakerGpuMesh } from "facebaker/three-gpu";
import { Bone, Box3, Group, Matrix4, Object3D, Scene, Texture, Vector3 } from "three";
import { frame } from "./frame_matrix.js";

const golden = process.env["FB_GOLDEN"]!;

test("each corner keeps its vertex and its texture coordinates", async () => {
  for (const name of ["character", "uvs", "uvs-by-vertex", "tiny", "manifold"]) {
    const face = await load(`${golden}/accepted/${name}.fbk`), meshes = renderMeshes(face);
    meshes.forEach((render, index) => {
      const mesh = face.meshes[index]!;
      assert.equal(render.indices.length, mesh.triangles.length);
      render.indices.forEach((vertex, i) => assert.equal(render.source[vertex], mesh.triangles[i]));
      assert.equal(render.groups.reduce((sum, { count }) => sum + count, 0), render.indices.length);
      if (!mesh.uvCorners) return;
      // The first triangle of each polygon has its first three corners.
      let corner = 0, triangle = 0;
      for (const size of mesh.polygonSizes) {
        for (let k = 0; k < 3; ++k) {
          const pair: number = mesh.uvCorners[corner + k]!, vertex = render.indices[3 * triangle + k]!;
          assert.deepEqual(render.uvs!.slice(2 * vertex, 2 * vertex + 2), face.uvs!.slice(2 * pair, 2 * pair + 2));
        }
        corner += size;
        triangle += size - 2;
      }
      const to = new Float32Array(3 * render.vertexCount);
      scatter(render, face.restPositions, to);
      render.source.forEach((from, v) =>
        assert.deepEqual(to.slice(3 * v, 3 * v + 3), face.restPositions.slice(3 * from, 3 * from + 3)));
    });
    face.dispose();
  }
});

test("a mesh of three.js has the pose's positions and normals", async () => {
  const face = await load(`${golden}/accepted/character.fbk`), group = new FaceBakerMesh(face);
  const controls = face.createPose().fill(0.6), size = 3 * face.vertexCount;
  const arrays = group.meshes.map(({ geometry }) => geometry.getAttribute("position").array);
  group.update(controls);
  const expected = face.evaluateInto(controls, { positions: new Float32Array(size), normals: new Float32Array(size),
                                                 sockets: new Float32Array(12 * face.sockets.length) });
  group.meshes.forEach(({ geometry, name }, index) => {
    const mesh = face.meshes[index]!, render = renderMeshes(face)[index]!;
    assert.equal(name, mesh.name);
    assert.equal(geometry.getAttribute("position").array, arrays[index]); // in place
    for (const [attribute, values] of [["position", expected.positions], ["normal", expected.normals]] as const)
      render.source.forEach((from, v) => assert.deepEqual(
        Array.from(geometry.getAttribute(attribute).array.slice(3 * v, 3 * v + 3)),
        Array.from(values.slice(3 * from, 3 * from + 3))));
  });
  const at = group.sockets[0]!.matrix.elements;
  assert.deepEqual([at[12], at[13], at[14]], [3, 7, 11].map((i) => expected.sockets[i]));
  assert.equal(group.materials.length, face.materials.length + 1);
  group.dispose();
  face.dispose();
});

test("a mesh that is disposed of stays in the scene, and can be posed and drawn on", async () => {
  const face = await load(`${golden}/accepted/character.fbk`), scene = new Scene();
  for (const mesh of [new FaceBakerMesh(face), new FaceBakerGpuMesh(face)]) {
    let freed = 0;
    scene.add(mesh);
    for (const { geometry } of mesh.meshes) geometry.addEventListener("dispose", () => ++freed);
    for (const material of mesh.materials) material.addEventListener("dispose", () => ++freed);
    mesh.dispose();
    assert.equal(mesh.parent, scene);
    assert.equal(freed, mesh.meshes.length + mesh.materials.length);
    if (mesh instanceof FaceBakerMesh) mesh.update(face.createPose());
    mesh.dispose();
    assert.equal(freed, 2 * (mesh.meshes.length + mesh.materials.length));
  }
  face.dispose();
});

// What facebaker.h says of skins: the sum over the influences of weight * (where the joint is) * inverse_bind.
function skinned(face: FaceContents, places: readonly Matrix4[], vertex: number, posed: Float32Array): Vector3 {
  const { influences, joints, weights } = face.skin!, sum = new Vector3();
  const at = new Vector3().fromArray(posed, 3 * vertex);
  let all = 0;
  for (let i = influences * vertex; i < influences * (vertex + 1); ++i) {
    const matrix = places[joints[i]!]!.clone().multiply(frame(face.joints[joints[i]!]!.inverseBind));
    sum.addScaledVector(at.clone().applyMatrix4(matrix), weights[i]!);
    all += weights[i]!;
  }
  return all > 0 ? sum : at;
}

const turnBones = (bones: readonly Object3D[]) =>
  bones.forEach((bone, index) => bone.rotateX(0.4 - 0.2 * (index % 4)).translateY(0.1 * index));

test("a face is on its skin: bones move vertices and sockets", async () => {
  const face = await load(`${golden}/accepted/body.fbk`), mesh = new FaceBakerMesh(face);
  assert(face.skin && face.joints.length > 1);
  assert.deepEqual(mesh.bones.map(({ userData }) => userData["name"]), face.joints.map(({ name }) => name));
  turnBones(mesh.bones);
  mesh.position.set(1, 2, 3);
  mesh.updateMatrixWorld();
  const controls = face.createPose().fill(0.4), positions = face.evaluate(controls);
  mesh.update(controls);
  const places = mesh.bones.map(({ matrixWorld }) => matrixWorld);
  let moved = 0, skins = 0;
  mesh.meshes.forEach((part, index) => {
    if ("isSkinnedMesh" in part) ++skins;
    renderMeshes(face)[index]!.source.forEach((from, v) => {
      const at = part.localToWorld(part.getVertexPosition(v, new Vector3()));
      const plain = new Vector3().fromArray(positions, 3 * from);
      const follows = "isSkinnedMesh" in part;
      const expected = follows ? skinned(face, places, from, positions) : plain.clone().applyMatrix4(mesh.matrixWorld);
      assert(at.distanceTo(expected) < 1e-5 * face.diagonal, `vertex ${from}`);
      moved = Math.max(moved, at.sub(mesh.position).distanceTo(plain));
    });
  });
  assert(skins > 0 && moved > 0.05 * face.diagonal);
  const inBox = new Box3().setFromObject(mesh);
  mesh.meshes.forEach((part) => {
    for (let v = 0; v < part.geometry.getAttribute("position").count; ++v)
      assert(inBox.distanceToPoint(part.localToWorld(part.getVertexPosition(v, new Vector3()))) < 1e-5 * face.diagonal);
  });
  const unskinned = new FaceBakerMesh(face, { skin: false });
  assert.equal(unskinned.skeleton, null);
  assert(unskinned.meshes.every((part) => !("isSkinnedMesh" in part)));
  face.dispose();
});

test("a face follows the bones of a body, from where it was put", async () => {
  const face = await load(`${golden}/accepted/body.fbk`), mesh = new FaceBakerMesh(face, { metres: metresPerUnit(face.units) !== null });
  const body = new Group(), joints = mesh.bones.map(({ name }) => {
    const bone = new Bone(); // with axes of its own
    bone.name = name;
    bone.rotation.set(0.3, -1, 2);
    return bone;
  });
  body.add(...joints);
  mesh.position.set(0, 1.6, 0);
  mesh.updateMatrixWorld(true);
  const corner = () => mesh.meshes.flatMap((part) => "isSkinnedMesh" in part ? [part.localToWorld(part.getVertexPosition(0, new Vector3()))] : []);
  const before = corner();
  assert.deepEqual(mesh.followBones(body), []);
  body.updateMatrixWorld(true);
  mesh.updateMatrixWorld(true);
  corner().forEach((at, i) => assert(at.distanceTo(before[i]!) < 1e-5, "it jumps"));
  const step = new Matrix4().makeRotationY(0.7).setPosition(3, 0, 1);
  body.applyMatrix4(step); // all bones at once: the face goes along as one
  body.updateMatrixWorld(true);
  mesh.updateMatrixWorld(true);
  corner().forEach((at, i) => assert(at.distanceTo(before[i]!.clone().applyMatrix4(step)) < 1e-5, "it stays behind"));
  assert.deepEqual(new FaceBakerMesh(face).followBones(new Group()).length, face.joints.length);
  face.dispose();
});

test("sockets follow the joints of their surface", async () => {
  const face = await load(`${golden}/accepted/body.fbk`), { joints, skin } = face;
  const joint = skin!.joints[0]!;
  const contents: FaceContents = { ...face.contents(), sockets: [{
    name: "ear", vertices: Uint32Array.of(0), weights: Float32Array.of(1), frame: [1, 0, 0, 2, 0, 1, 0, 3, 0, 0, 1, 4] }],
    skin: { influences: 1, joints: new Uint16Array(face.vertexCount).fill(joint), weights: new Float32Array(face.vertexCount).fill(1) } };
  const mesh = new FaceBakerMesh(contents);
  turnBones(mesh.bones);
  mesh.rotation.set(1, 2, 3);
  mesh.updateMatrixWorld();
  const expected = mesh.bones[joint]!.matrixWorld.clone().multiply(frame(joints[joint]!.inverseBind))
    .multiply(frame(contents.sockets[0]!.frame));
  const found = mesh.sockets[0]!.matrixWorld;
  found.elements.forEach((value, i) => assert(Math.abs(value - expected.elements[i]!) < 1e-4, String(found.elements)));
  face.dispose();
});

test("a face says its scale, and is made in metres where that is asked for", async () => {
  const face = await load(`${golden}/accepted/character.fbk`), inCentimetres = { ...face.contents(), units: "cm" };
  const plain = new FaceBakerMesh(inCentimetres), metres = new FaceBakerMesh(inCentimetres, { metres: true });
  assert.equal(plain.metresPerUnit, 0.01);
  const sizeOf = (mesh: FaceBakerMesh) => new Box3().setFromObject(mesh).getSize(new Vector3()).length();
  assert(Math.abs(sizeOf(metres) / sizeOf(plain) - 0.01) < 1e-6);
  const ring = new Object3D();
  metres.sockets[0]!.add(ring);
  metres.updateMatrixWorld(true);
  assert(Math.abs(ring.matrixWorld.getMaxScaleOnAxis() - 1) < 1e-4); // what hangs on it is in metres
  const unknown = { ...inCentimetres, units: "heads" };
  assert.equal(new FaceBakerMesh(unknown).metresPerUnit, null);
  assert.throws(() => new FaceBakerMesh(unknown, { metres: true }), /"heads"/);
  face.dispose();
});

test("says when a texture has arrived, and leaves out one that never does", async () => {
  const face = await load(`${golden}/accepted/character.fbk`);
  const arrivals: ((problem?: string) => void)[] = [];
  const mesh = new FaceBakerMesh(face, { loadTexture: (_image, arrived) => {
    arrivals.push(arrived);
    return new Texture();
  } });
  assert(arrivals.length > 0);
  const map = () => mesh.materials.filter((material) => [material.map, material.normalMap, material.roughnessMap,
    material.aoMap, material.emissiveMap].some((texture) => texture !== null)).length;
  let told = 0;
  mesh.addEventListener("textureload", ({ texture }) => { if (texture instanceof Texture) ++told; });
  const before = map(), { warn } = console;
  arrivals[0]!();
  assert.equal(told, 1);
  assert.equal(map(), before);
  console.warn = () => undefined;
  for (const arrived of arrivals) arrived("it is broken");
  console.warn = warn;
  assert.equal(told, 1 + arrivals.length);
  assert.equal(map(), 0);
  face.dispose();
});

test("faces for one renderer do not say that they draw with another", async () => {
  const webGpu = { isWebGPURenderer: true, getContext: () => ({ getExtension: () => ({}) }), backend: {} };
  assert.equal(FaceBakerGpuMesh.isSupported(webGpu), false);
  const face = await load(`${golden}/accepted/character.fbk`), mesh = new FaceBakerGpuMesh(face);
  assert.throws(() => mesh.update(face.createPose(), webGpu as never), /three-webgpu/);
  face.dispose();
});

// Meshes for drawing: triangles, seams, and three.js' geometries.
import assert from "node:assert/strict";
import test from "node:test";
import { load } from "facebaker";
import { renderMeshes, scatter } from "facebaker/geometry";
import { FaceBakerMesh } from "facebaker/three";

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

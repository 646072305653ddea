// WGSL that moves vertices by the driven joints that they follow: core/archive/EVALUATION.md, "Driven joints". Of these
// floats rounding is the driver's.
import { workgroupSize } from "./digit_sums_shader.js";

/** Of a dispatch, each a word. */
export const skinParameterNames = ["vertices", "influences", "joints", "first_pose", "first_number", "first_vertex", "unused",
                                     "unused_too"] as const;
export type SkinParameters = Record<(typeof skinParameterNames)[number], number>;

/** Numbers of what a joint does: the upper three rows of a 4 x 4 matrix, less the identity. */
export const jointNumbers = 12;

export const skinShader = `
struct Parameters { ${skinParameterNames.map((name) => `${name}: u32`).join(", ")} }
struct Influence { joint: u32, weight: f32 }
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> influences: array<Influence>;
@group(0) @binding(2) var<storage, read> joints: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> positions: array<f32>;

@compute @workgroup_size(${workgroupSize})
fn skin(@builtin(global_invocation_id) thread: vec3<u32>) {
  let vertex = parameters.first_vertex + thread.x;
  if (vertex >= parameters.vertices) { return; }
  let pose = parameters.first_pose + thread.y;
  var rows = array(vec4(0.0), vec4(0.0), vec4(0.0));
  for (var i = 0u; i < parameters.influences; i++) {
    let influence = influences[vertex * parameters.influences + i];
    if (influence.weight == 0.0) { break; }
    let first = 3u * (pose * parameters.joints + influence.joint);
    for (var axis = 0u; axis < 3u; axis++) { rows[axis] += influence.weight * joints[first + axis]; }
  }
  let number = parameters.first_number + 3u * (pose * parameters.vertices + vertex);
  let at = vec4(positions[number], positions[number + 1u], positions[number + 2u], 1.0);
  for (var axis = 0u; axis < 3u; axis++) { positions[number + axis] = at[axis] + dot(rows[axis], at); }
}
`;

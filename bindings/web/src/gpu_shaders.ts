// GLSL of three_gpu.ts. Textures are those of gpu_layout.ts.
import { textureWidth } from "./gpu_layout.js";

const header = `precision highp float;
precision highp int;
precision highp sampler2D;
precision highp isampler2D;
precision highp usampler2D;
ivec2 texel(uint index) { return ivec2(index % ${textureWidth}u, index / ${textureWidth}u); }
`;

/** A triangle that covers the target. */
export const screenShader = `${header}
in vec3 position;
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }
`;

const begin = `${header}
uniform uint vertexCount;
out vec4 result;
uint thisVertex() { return uint(gl_FragCoord.y) * ${textureWidth}u + uint(gl_FragCoord.x); }
`;

// Where the driven joints that a vertex follows take it: core/archive/EVALUATION.md, "Driven joints".
const skinning = (influenceCount: number) => `
uniform sampler2D influences;
uniform sampler2D matrices;
vec3 skinned(uint vertex, vec3 at) {
  vec4 x = vec4(0.0), y = vec4(0.0), z = vec4(0.0);
  for (uint i = 0u; i < ${influenceCount}u; ++i) {
    vec2 influence = texelFetch(influences, texel(vertex * ${influenceCount}u + i), 0).xy;
    if (influence.y == 0.0) break;
    uint row = 3u * uint(influence.x);
    x += influence.y * texelFetch(matrices, texel(row), 0);
    y += influence.y * texelFetch(matrices, texel(row + 1u), 0);
    z += influence.y * texelFetch(matrices, texel(row + 2u), 0);
  }
  vec4 from = vec4(at, 1.0);
  return at + vec3(dot(x, from), dot(y, from), dot(z, from));
}
`;

/** Rest position plus the digits of the vertex times the weights of the pose, moved by the driven joints that the
 * vertex follows, `influenceCount` at most. */
export const positionShader = (influenceCount: number) => `${begin}${influenceCount > 0 ? skinning(influenceCount) : ""}
uniform isampler2D digits;
uniform usampler2D blocks;
uniform sampler2D rest;
uniform sampler2D weights;
void main() {
  uint vertex = thisVertex();
  if (vertex >= vertexCount) discard;
  uvec4 block = texelFetch(blocks, texel(vertex), 0);
  vec3 moved = vec3(0.0);
  for (uint c = 0u; c < block.w; ++c) {
    float weight = texelFetch(weights, texel(block.z + c), 0).r;
    if (weight != 0.0) moved += weight * vec3(texelFetch(digits, texel(block.x + c * block.y), 0).xyz);
  }
  vec3 at = texelFetch(rest, texel(vertex), 0).xyz + moved;
  result = vec4(${influenceCount > 0 ? "skinned(vertex, at)" : "at"}, 1.0);
}
`;

/** The normalised sum of the area vectors of the polygons around a vertex. */
export const normalShader = `${begin}
uniform sampler2D positions;
uniform usampler2D around;
uniform usampler2D polygons;
vec3 at(uint vertex) { return texelFetch(positions, texel(vertex), 0).xyz; }
void main() {
  uint vertex = thisVertex();
  if (vertex >= vertexCount) discard;
  uvec2 entries = texelFetch(around, texel(vertex), 0).xy;
  vec3 sum = vec3(0.0);
  for (uint i = 0u; i < entries.y; ++i) {
    uvec2 first = texelFetch(polygons, texel(entries.x + 2u * i), 0).xy;
    uvec2 last = texelFetch(polygons, texel(entries.x + 2u * i + 1u), 0).xy;
    sum += cross(at(first.x) - at(first.y), at(last.x) - at(last.y));
  }
  float size = length(sum);
  result = vec4(size > 0.0 ? sum / size : vec3(0.0), 0.0);
}
`;

/** What the vertex shaders of three.js' materials get. */
export const vertexHeader = `
in uint faceVertex;
uniform highp sampler2D facePositions;
uniform highp sampler2D faceNormals;
ivec2 faceTexel() { return ivec2(faceVertex % ${textureWidth}u, faceVertex / ${textureWidth}u); }
`;

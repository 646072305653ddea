// WGSL of webgpu.ts. Positions are bits of f32 in u32 all the way, see exact_arithmetic_shader.ts.
import { exactArithmetic } from "./exact_arithmetic_shader.js";
import { quadWords } from "./packed_digits.js";

/** Poses that a workgroup sums together: digits are unpacked once for all of them. */
export const posesOfOctet = 8;
/** Threads of a workgroup: the triples of a panel, or vertices. */
export const workgroupSize = 64;
/** Words of a panel in `basis`: its first row, its rows, its row block, its first header. */
export const panelWords = 4;

/** Of a dispatch, each a word. Octets are eight poses of a chunk, one after the other. `basis` begins with the panels,
 * `rest` with the rows of the rest mesh, the place of each vertex, and where the corrections of each exact pose and panel
 * begin, 0: nowhere; `lists` with the entries of each octet and row block, from one number to the next. */
export const parameterNames = [
  "first_panel", "first_octet", "poses", "blocks", "panels", "exact", "vertices", "octets",
  "quads", // where in `lists` the quads of entries begin
  "first_number", // in `positions`
  "displacements", "unused",
] as const;
export type SumParameters = Record<(typeof parameterNames)[number], number>;

const parameters = `
struct Parameters { ${parameterNames.map((name) => `${name}: u32`).join(", ")} }
@group(0) @binding(0) var<uniform> parameters: Parameters;
`;

const octet = Array.from({ length: posesOfOctet }, (_, pose) => pose);
const axes = [0, 1, 2];

// Products of a quad's digits, a byte a column for each axis, with the four factors of a pose, each of a low and a high
// byte: by WGSL's dot4I8Packed, or unpacked, where a browser does not have it.
const packedProducts = `
fn products_of(digits: vec3<u32>, low: u32, high: u32) -> vec3<i32> {
  let lows = vec3(dot4I8Packed(digits.x, low), dot4I8Packed(digits.y, low), dot4I8Packed(digits.z, low));
  return lows + 256 * vec3(dot4I8Packed(digits.x, high), dot4I8Packed(digits.y, high), dot4I8Packed(digits.z, high));
}
`;
const unpackedProducts = `
fn products_of(digits: vec3<u32>, low: u32, high: u32) -> vec3<i32> {
  var products = vec3(0);
  for (var column = 0u; column < 4u; column++) {
    let first = 8u * column;
    let factor = extractBits(i32(low), first, 8u) + 256 * extractBits(i32(high), first, 8u);
    products += factor * extractBits(bitcast<vec3<i32>>(digits), first, 8u);
  }
  return products;
}
`;

const addProducts = (pose: number): string =>
  `    sums${pose} += products_of(digits, low[${pose >> 2}][${pose % 4}], high[${pose >> 2}][${pose % 4}]);`;

/** Sums of the digits of the basis times quantised coefficients, and the positions that come of them. */
export const digitSumsShader = (integerDot: boolean): string => `
${integerDot ? "requires packed_4x8_integer_dot_product;" : ""}${parameters}
@group(0) @binding(1) var<storage, read> basis: array<u32>;
@group(0) @binding(2) var<storage, read> rest: array<u32>;
@group(0) @binding(3) var<storage, read> lists: array<u32>;
@group(0) @binding(4) var<storage, read> factors: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> positions: array<u32>;
${exactArithmetic}${integerDot ? packedProducts : unpackedProducts}
// Words of the digits of these widths.
fn words_of(widths: u32) -> u32 {
  return countOneBits(widths & 0x555555u) + 2u * countOneBits(widths & 0xaaaaaau)
       + countOneBits(widths & (widths >> 1u) & 0x555555u); // 3 stands for four words
}

// The digits of a triple in a quad, a byte a column.
fn digits_of(header: u32, triple: u32) -> vec3<u32> {
  let first = ${panelWords}u * parameters.panels + basis[header];
  let group = triple / 16u;
  let place = triple % 16u;
  var digits = vec3(0u);
  for (var column = 0u; column < 4u; column++) {
    let widths = basis[header + 1u + column];
    var word = first + (widths >> 24u) + words_of(widths & ((1u << (6u * group)) - 1u));
    for (var axis = 0u; axis < 3u; axis++) {
      let width = (widths >> (6u * group + 2u * axis)) & 3u;
      if (width == 0u) { continue; }
      let bits = 1u << width;
      let at = place * bits;
      let digit = extractBits(i32(basis[word + at / 32u]), at % 32u, bits);
      digits[axis] |= (u32(digit) & 0xffu) << (8u * column);
      word += bits / 2u;
    }
  }
  return digits;
}

// The bits of a row's position, or displacement.
fn position_of(row: u32, of_panel: u32, panel: u32, block: u32, octet: u32, pose: u32, sum: i32) -> u32 {
  let at_rest = rest[row];
  var position = at_rest;
  let steps = parameters.octets * parameters.blocks + 1u;
  let step = lists[steps + (octet * parameters.blocks + block) * 8u + pose];
  if (step != 0u) { position = added(at_rest, multiplied(step, float_of(sum))); }
  let weights = steps + (parameters.octets * parameters.blocks + octet * parameters.exact) * 8u;
  for (var exact = 0u; exact < parameters.exact; exact++) {
    let weight = lists[weights + exact * 8u + pose];
    let corrections = rest[4u * parameters.vertices + exact * parameters.panels + panel];
    if (weight == 0u || corrections == 0u) { continue; }
    position = added(position, multiplied(weight, rest[corrections + of_panel]));
  }
  if (parameters.displacements != 0u) { position = added(position, at_rest ^ 0x80000000u); }
  return position;
}

var<workgroup> kept: array<i32, ${24 * workgroupSize}>; // each thread its own: indexed by numbers that vary

@compute @workgroup_size(${workgroupSize})
fn sum_digits(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) triple: u32) {
  let panel = parameters.first_panel + group.x;
  let octet = parameters.first_octet + group.y;
  let first_row = basis[${panelWords}u * panel];
  let rows = basis[${panelWords}u * panel + 1u];
  let block = basis[${panelWords}u * panel + 2u];
  let headers = ${panelWords}u * parameters.panels + basis[${panelWords}u * panel + 3u];
  let begin = lists[octet * parameters.blocks + block];
  let end = lists[octet * parameters.blocks + block + 1u];
${octet.map((pose) => `  var sums${pose} = vec3(0);`).join("\n")}
  for (var at = begin; at < end; at++) {
    let digits = digits_of(headers + ${quadWords}u * lists[parameters.quads + at], triple);
    let low = array(factors[4u * at], factors[4u * at + 1u]);
    let high = array(factors[4u * at + 2u], factors[4u * at + 3u]);
${octet.map(addProducts).join("\n")}
  }
  let own = triple * 24u;
${octet.flatMap((pose) => axes.map((axis) => `  kept[own + ${3 * pose + axis}u] = sums${pose}[${axis}];`)).join("\n")}
  for (var number = 0u; number < 24u; number++) {
    let pose = number / 3u;
    let of_panel = 3u * triple + number % 3u;
    if (octet * 8u + pose >= parameters.poses || of_panel >= rows) { continue; }
    let row = first_row + of_panel;
    let vertex = (octet * 8u + pose) * parameters.vertices + rest[3u * parameters.vertices + row / 3u];
    positions[parameters.first_number + 3u * vertex + row % 3u] =
      position_of(row, of_panel, panel, block, octet, pose, kept[own + number]);
  }
}
`;

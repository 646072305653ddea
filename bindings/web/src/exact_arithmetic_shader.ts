/** WGSL functions that compute with the bits of f32, in u32: each operation rounded to nearest, halves to even, denormals
 * kept. WGSL leaves rounding, denormals and fused operations of its own f32 to the driver; integers have one result. */
export const exactArithmetic = `
const infinity: u32 = 0x7f800000u;
const not_a_number: u32 = 0x7fc00000u;

// top / 2^31 * 2^(exponent - 127), where bit 31 of \`top\` is set, and bit 0 where anything is below it.
fn rounded(sign: u32, exponent: i32, top: u32) -> u32 {
  if (exponent >= 255) { return sign | infinity; }
  var bits = top;
  if (exponent <= 0) { // denormal
    let shift = u32(1 - exponent);
    if (shift > 31u) { bits = 1u; }
    else { bits = (top >> shift) | select(0u, 1u, (top & ((1u << shift) - 1u)) != 0u); }
  }
  let kept = bits >> 8u;
  let up = (bits >> 7u) & select(kept & 1u, 1u, (bits & 0x7fu) != 0u);
  return sign | ((u32(max(exponent, 1) - 1) << 23u) + kept + up);
}

fn float_of(number: i32) -> u32 {
  if (number == 0) { return 0u; }
  let size = select(u32(number), 0u - u32(number), number < 0);
  let zeros = countLeadingZeros(size);
  return rounded(u32(number) & 0x80000000u, 158 - i32(zeros), size << zeros);
}

// The exponent of a number above 0, and its 24 bits, the first of which is 1.
fn parts(number: u32) -> vec2<u32> {
  let fraction = number & 0x7fffffu;
  if (number >= 0x800000u) { return vec2(number >> 23u, fraction | 0x800000u); }
  let shift = countLeadingZeros(fraction) - 8u;
  return vec2(1u - shift, fraction << shift);
}

fn multiplied(a: u32, b: u32) -> u32 {
  let sign = (a ^ b) & 0x80000000u;
  let x = a & 0x7fffffffu;
  let y = b & 0x7fffffffu;
  if (x >= infinity || y >= infinity) {
    return select(sign | infinity, not_a_number, x > infinity || y > infinity || x == 0u || y == 0u);
  }
  if (x == 0u || y == 0u) { return sign; }
  let p = parts(x);
  let q = parts(y);
  // 48 bits of 12 by 12: the upper 32, and whether anything is below.
  let low = (p.y & 0xfffu) * (q.y & 0xfffu);
  let middle = (p.y & 0xfffu) * (q.y >> 12u) + (p.y >> 12u) * (q.y & 0xfffu);
  let below = ((middle & 15u) << 12u) + low;
  let top = (((p.y >> 12u) * (q.y >> 12u)) << 8u) + (middle >> 4u) + (below >> 16u);
  let rest = select(0u, 1u, (below & 0xffffu) != 0u);
  let exponent = i32(p.x + q.x) - 126;
  if ((top & 0x80000000u) != 0u) { return rounded(sign, exponent, top | rest); }
  return rounded(sign, exponent - 1, (top << 1u) | rest);
}

fn added(a: u32, b: u32) -> u32 {
  let swap = (a & 0x7fffffffu) < (b & 0x7fffffffu);
  let larger = select(a, b, swap);
  let smaller = select(b, a, swap);
  let x = larger & 0x7fffffffu;
  let y = smaller & 0x7fffffffu;
  let opposite = ((a ^ b) & 0x80000000u) != 0u;
  if (x >= infinity) { return select(larger, not_a_number, x > infinity || (y == infinity && opposite)); }
  if (y == 0u) { return select(larger, a & b, x == 0u); }
  let exponent = max(x >> 23u, 1u);
  let shift = exponent - max(y >> 23u, 1u);
  let wide = ((x & 0x7fffffu) | select(0u, 0x800000u, x >= 0x800000u)) << 7u;
  let narrow = ((y & 0x7fffffu) | select(0u, 0x800000u, y >= 0x800000u)) << 7u;
  var shifted = 1u;
  if (shift < 32u) { shifted = (narrow >> shift) | select(0u, 1u, (narrow & ((1u << shift) - 1u)) != 0u); }
  let sum = select(wide + shifted, wide - shifted, opposite);
  if (sum == 0u) { return 0u; }
  let zeros = countLeadingZeros(sum);
  return rounded(larger & 0x80000000u, i32(exponent + 1u) - i32(zeros), sum << zeros);
}
`;

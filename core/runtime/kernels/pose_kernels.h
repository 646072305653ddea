// The inner loops of the runtime, once for each instruction set. All sets give the same bits. Kernel files include only
// this header: other inline functions compiled for their instruction set could be linked into code for lesser
// processors.
#pragma once

#include <cstddef>
#include <cstdint>

#include "model/activation.h"
#include "model/control_feature.h"

namespace fb::runtime {

// Poses of a batch that are evaluated together, so that matrix digits are read and unpacked once for all of them.
inline constexpr std::size_t poses_per_block = 8;

// The most rows of a panel of columns and of a panel of quads.
inline constexpr std::size_t column_panel_rows = 192, quad_panel_rows = 128;
inline constexpr std::size_t max_panel_rows = column_panel_rows;
// Stored columns and quads are a multiple of so many rows long.
inline constexpr std::size_t column_group = 64, quad_group = 32;

// A quad is four columns interleaved row by row, in the order 0, 2, 1, 3: the even bytes of a row belong to the first
// two columns and the odd bytes to the last two.
inline constexpr std::size_t quad_columns = 4;
[[gnu::always_inline]] inline std::size_t quad_position(std::size_t column) {
  return column % 2 * 2 + column / 2 % 2;
}

// The quantised inputs of a panel in 1 or poses_per_block poses.
struct PanelInputs {
  // Where the column of each input is in the panel's digits; unused for quads, whose inputs are all columns in order.
  const std::uint32_t* offsets;
  // -32512..32512: by four inputs, then by pose. Not null.
  const std::int16_t* values;
  std::size_t count;                  // a multiple of 4: padded with zeros, for existing columns
  std::size_t poses;                  // 1 or poses_per_block
  const std::uint32_t* initial_sums;  // by pose: -128 x the sum of its inputs, modulo 2^32; corrects the digits' offset
};

// Rows of a matrix. A byte of `digits` is a digit + 128, but see PoseKernels::signed_odd_digits. The rows of
// columns are in an order of their own, see PoseKernels::column_rows.
struct Panel {
  const std::uint8_t* digits;
  std::size_t rows;
  std::size_t stride;  // bytes from quad to quad
};

// Where the products of a panel go: row r of pose p becomes (scales[r] * steps[p]) * f32(sum) + bias[r], where sum is
// that of the columns' (input of pose p) x (digit of row r). Arrays by row are readable up to the next multiple of
// `padding`; no more than the panel's rows are written.
struct PanelOutput {
  const float* scales;  // null: all are 1
  const float* bias;
  const float* steps;
  float* const* rows;
};

// The caller guarantees that final sums fit 32 bits; partial sums may wrap modulo 2^32.
using PanelProduct = void (*)(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output);

// Arrays of floats have room up to the next multiple of this.
inline constexpr std::size_t padding = 16;

// The result of quantising an array: its step and the sum of its integers modulo 2^32.
struct Quantisation {
  float step = 0;  // 0: all numbers are 0, and no integer was written
  std::uint32_t sum = 0;
};

// Features of controls, as arrays of `count` numbers.
struct ControlFeatures {
  const std::uint32_t* controls;
  const FeatureKind* kinds;
  const float *scales, *thresholds, *falls;
  std::size_t count;
};

// The corners of a quad, as offsets in rows, which are readable one float beyond a corner; of a triangle the last
// repeats the first.
struct Quad {
  std::uint32_t offset[4];
};

// Of the last three corners of a quad.
struct QuadWeights {
  float of[3];
};

// The first polygons at a vertex, as offsets in vectors of four floats; 0, where there is a null vector, for fewer.
struct FirstPolygons {
  std::uint32_t offset[4];
};

// A further polygon of each of eight vertices; 4, where there is a vector of -0, which changes no sum, for those that
// have fewer.
struct FurtherPolygons {
  static constexpr std::uint32_t vertices = 8;
  std::uint32_t offset[vertices];
};

// The polygons around vertices begin..end - 1, of which `begin` is a multiple of eight.
struct PolygonsAround {
  std::uint32_t begin, end;
  const FirstPolygons* first;          // by vertex, from 0; readable seven beyond the last
  const FurtherPolygons* further;      // of all vertices
  const std::uint32_t* further_begin;  // by eight vertices from 0, and one more: their first in `further`
};

// Floats before the vectors of polygons: a null vector, and one of -0.
inline constexpr std::size_t no_polygon_floats = 8;

// How a joint that vertices follow moved: four columns of three numbers and a zero, which are added to the axes and the
// origin of space.
inline constexpr std::uint32_t joint_matrix_floats = 16;
struct alignas(64) JointMatrix {
  float numbers[joint_matrix_floats] = {};
};

// A joint that a vertex follows, by where its matrix is among those of all joints.
struct JointInfluence {
  std::uint32_t offset;
  float weight;
};

struct SkinTable {
  const std::uint32_t* first;  // by vertex, and one more: of its influences
  const JointInfluence* influences;
};

// Eight vertices in a row that follow the same joints, in the same order, some with a weight of 0.
struct SkinGroup {
  static constexpr std::uint32_t vertices = 8, most_joints = 4;
  std::uint32_t first_row, joints;
  std::uint32_t offset[most_joints];  // see JointInfluence
  std::uint32_t first_weight;         // eight of each joint
};

// Rows of floats, `stride` apart.
struct ProductRows {
  float* first;
  std::size_t stride, count;
};

struct PoseKernels {
  const char* name;
  PanelProduct column_product, quad_product;
  // Where in each column_group rows of a column each of them is stored.
  const std::uint8_t* column_rows;
  // Whether every second byte of a column is a signed digit, without 128 added. A pair of bytes is then a signed number
  // of which the low byte need not be cut off: its product has 256 times that of the high byte too much.
  bool signed_odd_digits;
  // The loops of float_kernels.h.
  bool (*any_nan)(const float* x, std::size_t count);
  // offsets[i * stride] = control i, clamped to its range, minus its rest value. Returns how many were out of range.
  std::uint32_t (*clamp_controls)(const float* controls, const float* minimum, const float* maximum, const float* rest,
                                  std::size_t count, float* offsets, std::size_t stride);
  // values[i * poses + p]: feature i of pose p, from offsets laid out alike. poses: 1 or poses_per_block.
  void (*control_features)(const ControlFeatures& features, const float* offsets, std::size_t poses, float* values);
  // Writes the indices of the values of one pose that are not 0, and returns how many. `indices` has room for count
  // + 16.
  std::size_t (*compact_nonzeros)(const float* values, std::size_t count, std::uint32_t* indices);
  // EVALUATION.md, "Quantise": one pose. Both arrays are padded; padding of x is ignored.
  Quantisation (*quantise)(const float* x, std::size_t count, float limit, std::int16_t* quantised);
  // The same for poses_per_block poses, input i of pose p at x[i * poses_per_block + p]. `quantised` is in the order of
  // PanelInputs::values, and poses of zeros are written too. Pads x with zeros to a multiple of 4 inputs.
  void (*quantise_block)(float* x, std::size_t count, float limit, std::int16_t* quantised, Quantisation* results);
  // y = (scales * step) * (256 * high + low) + bias
  void (*join_digits)(const float* low, const float* high, const float* scales, float step, const float* bias, float* y,
                      std::size_t count);
  void (*activate)(Activation activation, float* y, std::size_t count);
  // IEEE 754 binary16, rounded to nearest even.
  void (*convert_to_half)(const float* numbers, std::uint16_t* halves, std::size_t count);
  // `count` of quads is even. vectors[4 i ..]: twice the area vector of quad i in units of 1 / scale squared, as z, x,
  // y and an undefined number.
  void (*quad_areas)(const Quad* quads, std::size_t count, const float* rows, float scale, float* vectors);
  // vectors[4 i ..]: the weighted sum of the offsets of a quad's corners from its first, and an undefined number.
  void (*quad_integrals)(const Quad* quads, const QuadWeights* weights, std::size_t count, const float* rows,
                         float* vectors);
  // Unit normals, 3 floats a vertex from 0, from area vectors; null where their sum has no finite, positive length.
  void (*vertex_normals)(const PolygonsAround& around, const float* areas, float* normals);
  // Unit tangents likewise from integrals: orthogonal to the normals, which are readable 25 floats beyond the last;
  // null where the normal is null or there is no such direction.
  void (*vertex_tangents)(const PolygonsAround& around, const float* integrals, const float* normals, float* tangents);
  // Moves vertices begin..end - 1, 3 floats each and readable one float beyond, by the joints that they follow.
  void (*skin_vertices)(const SkinTable& skin, std::uint32_t begin, std::uint32_t end, const float* matrices,
                        float* rows);
  // The same for groups of vertices, of matrices whose numbers are finite.
  void (*skin_groups)(const SkinGroup* groups, std::size_t count, const float* weights, const float* matrices,
                      float* rows);
  // The loops of linear_kernels.h. `length` is a multiple of `padding`, and so is `stride` from row to row.
  // to[i] += factors[k] * (row k)[i], for k from 0.
  void (*add_rows)(float* to, const float* factors, const float* rows, std::size_t stride, std::size_t count,
                   std::size_t length);
  // The same for each row of `to`, with a row of factors of its own: a product of matrices.
  void (*add_products)(const ProductRows& to, const ProductRows& factors, const float* rows, std::size_t stride,
                       std::size_t count, std::size_t length);
  // sums[k]: the dot product of x and row k, of `padding` partial sums.
  void (*dot_products)(const float* x, const float* rows, std::size_t stride, std::size_t count, std::size_t length,
                       float* sums);
};

extern const PoseKernels scalar_kernels;
#if defined(__x86_64__)
extern const PoseKernels sse2_kernels, avx2_kernels, avx_vnni_kernels, avx512_vnni_kernels;
#elif defined(__aarch64__)
extern const PoseKernels neon_kernels, neon_dot_kernels;
#elif defined(__wasm_simd128__)
extern const PoseKernels wasm_simd_kernels;
#endif

}  // namespace fb::runtime

/* What a batch can be asked for besides positions in the source's order, and the basis. */
#define POSES 7
#define WORKERS 2
#include "batch_fixture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void baked_order_is_the_sources_order_permuted(void** state) {
  (void)state;
  float positions[POSES * FLOATS];
  fb_batch_desc desc = describe(positions, POSES * FLOATS);
  desc.vertex_order = FB_ORDER_BAKED;
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
  const uint32_t* order = fb_vertex_order(model);
  assert_non_null(order);
  for (int p = 0; p < POSES; ++p)
    for (int i = 0; i < VERTICES; ++i)
      assert_memory_equal(positions + p * FLOATS + 3 * i, expected + p * FLOATS + 3 * order[i], 12);
}

/* The value of a binary16. */
static double half_value(uint16_t half) {
  const int exponent = half >> 10 & 31;
  const double size = exponent ? ldexp(1024 + (half & 1023), exponent - 25) : ldexp(half & 1023, -24);
  return half & 0x8000 ? -size : size;
}

static void halves_are_the_nearest(void** state) {
  (void)state;
  uint16_t halves[POSES * FLOATS];
  for (uint32_t order = FB_ORDER_SOURCE; order <= FB_ORDER_BAKED; ++order) {
    float floats[POSES * FLOATS];
    fb_batch_desc desc = describe(floats, POSES * FLOATS);
    desc.vertex_order = order;
    assert_ok(fb_evaluate_batch(model, scratch, &desc));
    desc.positions = halves;
    desc.format = FB_FLOAT16;
    assert_ok(fb_evaluate_batch(model, scratch, &desc));
    for (int i = 0; i < POSES * FLOATS; ++i) {
      const double error = fabs(half_value(halves[i]) - floats[i]);
      const uint16_t up = (uint16_t)(halves[i] + 1), down = (uint16_t)(halves[i] - 1);
      assert_true(error <= fabs(half_value(up) - floats[i]));
      if (halves[i] & 0x7fff) assert_true(error <= fabs(half_value(down) - floats[i]));
      assert_true((signbit(floats[i]) != 0) == halves[i] >> 15);
    }
  }
}

static void normals_are_unit_or_null_and_those_of_the_posed_mesh(void** state) {
  (void)state;
  enum { stride = 4 };
  float normals[POSES * VERTICES * stride];
  for (int i = 0; i < POSES * VERTICES * stride; ++i) normals[i] = 77;
  fb_batch_desc desc = describe(NULL, 0);
  desc.normals = normals;
  desc.normal_numbers = POSES * VERTICES * stride;
  desc.normal_vertex_stride = stride;
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
  const uint32_t *sizes = fb_polygon_sizes(model), *first = fb_polygon_corners(model);
  for (int p = 0; p < POSES; ++p) {
    double sums[FLOATS] = {0};
    const uint32_t* corners = first;
    for (uint32_t polygon = 0; polygon < fb_polygon_count(model); corners += sizes[polygon++]) {
      double area[3] = {0};
      for (uint32_t k = 0; k < sizes[polygon]; ++k)
        for (int a = 0; a < 3; ++a) {
          const float *u = expected + p * FLOATS + 3 * corners[k],
                      *v = expected + p * FLOATS + 3 * corners[(k + 1) % sizes[polygon]];
          area[a] += (double)u[(a + 1) % 3] * v[(a + 2) % 3] - (double)u[(a + 2) % 3] * v[(a + 1) % 3];
        }
      for (uint32_t k = 0; k < sizes[polygon]; ++k)
        for (int a = 0; a < 3; ++a) sums[3 * corners[k] + a] += area[a];
    }
    for (int v = 0; v < VERTICES; ++v) {
      const double* s = sums + 3 * v;
      const double length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
      const float* n = normals + (p * VERTICES + v) * stride;
      for (int a = 0; a < 3; ++a) assert_true(fabs(n[a] - (length > 0 ? s[a] / length : 0)) < 2e-5);
      assert_true(n[3] == 77);
    }
  }
}

static void everything_at_once_and_pose_by_pose_are_the_same(void** state) {
  (void)state;
  float positions[POSES * FLOATS], normals[POSES * FLOATS], tangents[POSES * FLOATS], position[FLOATS], normal[FLOATS],
      tangent[FLOATS];
  fb_batch_desc desc = describe(positions, POSES * FLOATS);
  desc.normals = normals;
  desc.normal_numbers = POSES * FLOATS;
  desc.tangents = tangents;
  desc.tangent_numbers = POSES * FLOATS;
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
  for (int v = 0; v < POSES * FLOATS; v += 3) {
    const float *n = normals + v, *t = tangents + v;
    assert_true(fabs(t[0] * t[0] + t[1] * t[1] + t[2] * t[2] - 1) < 1e-5);
    assert_true(fabs(t[0] * n[0] + t[1] * n[1] + t[2] * n[2]) < 1e-5);
  }
  assert_memory_equal(positions, expected, sizeof positions);
  for (int p = POSES - 1; p >= 0; --p) {
    fb_batch_desc one = describe(position, FLOATS);
    one.poses = 1;
    one.controls += p * CONTROLS;
    one.control_floats = CONTROLS;
    one.normals = normal;
    one.normal_numbers = FLOATS;
    one.tangents = tangent;
    one.tangent_numbers = FLOATS;
    assert_ok(fb_evaluate_batch(model, scratch, &one));
    assert_memory_equal(position, positions + p * FLOATS, sizeof position);
    assert_memory_equal(normal, normals + p * FLOATS, sizeof normal);
    assert_memory_equal(tangent, tangents + p * FLOATS, sizeof tangent);
  }
}

static void regions_left_out_give_what_they_give_at_rest(void** state) {
  (void)state;
  assert_int_equal(fb_region_count(model), 2);
  assert_string_equal(fb_region_name(model, 0), "face");
  assert_string_equal(fb_region_name(model, 1), "brow");
  assert_null(fb_region_name(model, 2));
  const uint32_t regions[] = {1, 0};
  float all[POSES * FLOATS], some[POSES * FLOATS], none[POSES * FLOATS];
  fb_batch_desc desc = describe(all, POSES * FLOATS);
  desc.regions = regions;
  desc.region_count = 2;
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
  assert_memory_equal(all, expected, sizeof all);
  desc.positions = some;
  desc.region_count = 1;
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
  assert_memory_not_equal(some, expected, sizeof some);
  desc.positions = none;
  desc.region_count = 0;
  assert_ok(fb_evaluate_batch(model, scratch, &desc));
  assert_memory_not_equal(none, some, sizeof none);
  const uint32_t wrong[] = {0, 2};
  desc.regions = wrong;
  desc.region_count = 2;
  assert_int_equal(fb_evaluate_batch(model, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
}

static void coefficients_times_basis_are_the_displacements(void** state) {
  (void)state;
  const uint32_t count = fb_coefficient_count(model), *order = fb_vertex_order(model);
  float* coefficients = malloc(count * sizeof(float));
  for (int p = 0; p < POSES; ++p) {
    assert_ok(fb_evaluate_coefficients(model, scratch, controls + p * CONTROLS, coefficients));
    double moved[FLOATS];
    for (int i = 0; i < FLOATS; ++i) moved[i] = fb_rest_positions(model)[i];
    uint32_t rows = 0;
    for (uint32_t g = 0; g < fb_row_block_count(model); ++g) {
      fb_row_block group;
      fb_row_block_init(&group);
      assert_ok(fb_row_block_at(model, g, &group));
      assert_int_equal(group.first_row, rows);
      rows += group.row_count;
      uint32_t* columns = malloc(group.column_count * sizeof(uint32_t));
      float* values = malloc(group.column_count * group.row_count * sizeof(float));
      assert_ok(fb_row_block_values(model, g, columns, values));
      for (uint32_t c = 0; c < group.column_count; ++c)
        for (uint32_t r = 0; r < group.row_count; ++r) {
          const uint32_t row = group.first_row + r;
          moved[3 * order[row / 3] + row % 3] += (double)coefficients[columns[c]] * values[c * group.row_count + r];
        }
      free(columns);
      free(values);
    }
    assert_int_equal(rows, FLOATS);
    for (int i = 0; i < FLOATS; ++i) assert_true(fabs(moved[i] - expected[p * FLOATS + i]) < 1e-3);
  }
  assert_ok(fb_evaluate_coefficients(model, scratch, fb_rest_controls(model), coefficients));
  for (uint32_t i = 0; i < count; ++i) assert_true(coefficients[i] == 0);
  fb_row_block group;
  fb_row_block_init(&group);
  assert_int_equal(fb_row_block_at(model, fb_row_block_count(model), &group), FB_ERROR_INVALID_ARGUMENT);
  free(coefficients);
}

static void digits_times_scales_are_the_basis(void** state) {
  (void)state;
  uint32_t wide = 0;
  for (uint32_t g = 0; g < fb_row_block_count(model); ++g) {
    fb_row_block group;
    fb_row_block_init(&group);
    assert_ok(fb_row_block_at(model, g, &group));
    assert_true(group.digit_column_count >= group.column_count);
    wide += group.digit_column_count - group.column_count;
    uint32_t* columns = malloc(group.column_count * sizeof(uint32_t));
    float* values = malloc(group.column_count * group.row_count * sizeof(float));
    uint32_t* digit_columns = malloc(group.digit_column_count * sizeof(uint32_t));
    float* scales = malloc(group.digit_column_count * sizeof(float));
    int8_t* digits = malloc(group.digit_column_count * group.row_count);
    assert_ok(fb_row_block_values(model, g, columns, values));
    assert_ok(fb_row_block_digits(model, g, digit_columns, scales, digits));
    for (uint32_t c = 0; c < group.column_count; ++c)
      for (uint32_t r = 0; r < group.row_count; ++r) {
        double sum = 0, largest = 0;
        for (uint32_t d = 0; d < group.digit_column_count; ++d) {
          if (digit_columns[d] != columns[c]) continue;
          sum += (double)scales[d] * digits[d * group.row_count + r];
          largest = fmax(largest, scales[d]);
        }
        assert_true(fabs(sum - values[c * group.row_count + r]) <= 1e-5 * largest);
      }
    assert_int_equal(fb_row_block_digits(model, g, NULL, scales, digits), FB_ERROR_INVALID_ARGUMENT);
    assert_int_equal(fb_row_block_digits(model, g, digit_columns, NULL, digits), FB_ERROR_INVALID_ARGUMENT);
    assert_int_equal(fb_row_block_digits(model, g, digit_columns, scales, NULL), FB_ERROR_INVALID_ARGUMENT);
    assert_int_equal(fb_row_block_digits(model, fb_row_block_count(model), digit_columns, scales, digits),
                     FB_ERROR_INVALID_ARGUMENT);
    free(columns);
    free(values);
    free(digit_columns);
    free(scales);
    free(digits);
  }
  assert_true(wide > 0);  // the fixture has columns of two digits
}

static void what_does_not_exist_is_refused(void** state) {
  (void)state;
  float positions[POSES * FLOATS];
  fb_batch_desc desc = describe(positions, POSES * FLOATS);
  desc.vertex_order = 2;
  assert_int_equal(fb_evaluate_batch(model, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
  desc.vertex_order = FB_ORDER_SOURCE;
  desc.format = 2;
  assert_int_equal(fb_evaluate_batch(model, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
  desc.format = FB_FLOAT32;
  desc.normals = positions;
  desc.normal_numbers = POSES * FLOATS - 1;
  assert_int_equal(fb_evaluate_batch(model, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
}

static void every_instruction_set_gives_the_same_bits(void** state) {
  (void)state;
  fb_load_desc load;
  fb_load_desc_init(&load);
  load.instruction_set = "scalar";
  fb_model* scalar = NULL;
  assert_ok(fb_load(FB_FIXTURE, &load, &scalar));
  assert_string_equal(fb_instruction_set(scalar), "scalar");
  assert_non_null(fb_instruction_set(model));
  fb_scratch* other = NULL;
  assert_ok(fb_scratch_create(scalar, 1, &other));
  float positions[POSES * FLOATS];
  fb_batch_desc desc = describe(positions, POSES * FLOATS);
  assert_ok(fb_evaluate_batch(scalar, other, &desc));
  assert_memory_equal(positions, expected, sizeof positions);
  fb_scratch_destroy(other);
  fb_release(scalar);
  load.instruction_set = "abacus";
  assert_int_equal(fb_load(FB_FIXTURE, &load, &scalar), FB_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(fb_last_error(), "\"abacus\" is not one of scalar"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(baked_order_is_the_sources_order_permuted),
      cmocka_unit_test(halves_are_the_nearest),
      cmocka_unit_test(normals_are_unit_or_null_and_those_of_the_posed_mesh),
      cmocka_unit_test(everything_at_once_and_pose_by_pose_are_the_same),
      cmocka_unit_test(regions_left_out_give_what_they_give_at_rest),
      cmocka_unit_test(coefficients_times_basis_are_the_displacements),
      cmocka_unit_test(digits_times_scales_are_the_basis),
      cmocka_unit_test(what_does_not_exist_is_refused),
      cmocka_unit_test(every_instruction_set_gives_the_same_bits),
  };
  return cmocka_run_group_tests(tests, open_model, close_model);
}

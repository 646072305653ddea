// Small functions of the model types.
#include <doctest/doctest.h>

#include "base/status.h"
#include "test_models.h"

namespace fb::test_model_types {

TEST_CASE("reach is the larger distance from rest") {
  CHECK(Control{"a", 0, 1, 0, ""}.reach() == 1);
  CHECK(Control{"a", -3, 1, 0, ""}.reach() == 3);
  CHECK(Control{"a", 0, 1, 0.25f, ""}.reach() == 0.75f);
}

TEST_CASE("controls are found by name; rest_pose lists the rest values") {
  const RigSchema schema = tiny_model().schema;
  CHECK(schema.find("brow_raise") == 2);
  CHECK_FALSE(schema.find("brow").has_value());
  CHECK(schema.rest_pose() == std::vector<float>{0, 0, 0.25f, 0, 0});
}

TEST_CASE("two rigs with different controls are refused by name") {
  const RigSchema a = tiny_model().schema;
  CHECK_NOTHROW(check_same_controls(a, "left", a, "right"));
  RigSchema b = a;
  b.controls.pop_back();
  CHECK_THROWS_WITH_AS(check_same_controls(a, "left", b, "right"), "left has 5 controls, right has 4", Error);
  b = a;
  b.controls[1].name = "other";
  CHECK_THROWS_WITH_AS(check_same_controls(a, "left", b, "right"), doctest::Contains("\"mouth_side\" in left"), Error);
  b = a;
  b.controls[1].maximum = 2;
  CHECK_THROWS_WITH_AS(check_same_controls(a, "left", b, "right"), doctest::Contains("another range"), Error);
}

TEST_CASE("a mesh computes its diagonal and triangle fans") {
  Mesh mesh{{0, 0, 0, 3, 0, 0, 3, 4, 0, 0, 4, 12, 1, 1, 1}, {4, 3}, {1, 2, 3, 0, 4, 0, 1}};
  CHECK(mesh.diagonal() == 13);
  CHECK(mesh.triangles() == std::vector<std::uint32_t>{1, 2, 3, 1, 3, 0, 4, 0, 1});
}

TEST_CASE("a network counts coefficients and parameters") {
  const Network network = tiny_model().network;
  CHECK(network.coefficient_count() == 2 + 3);
  CHECK(network.parameter_count() == (6 * 8 + 8) + (8 * 8 + 8) + (8 * 3 + 3));
}

TEST_CASE("a dense basis is cut into row blocks without columns of zeros") {
  const std::uint32_t rows = 2 * default_block_rows + 3;
  std::vector<float> dense(2 * rows, 0);
  dense[5] = 1;                          // column 0, block 0
  dense[rows + default_block_rows] = 2;  // column 1, block 1
  const Basis basis = make_basis(rows, 2, dense);
  CHECK_NOTHROW(check(basis));
  REQUIRE(basis.row_blocks.size() == 3);
  CHECK(basis.row_blocks[0].columns == std::vector<std::uint32_t>{0});
  CHECK(basis.row_blocks[0].values[5] == 1);
  CHECK(basis.row_blocks[1].columns == std::vector<std::uint32_t>{1});
  CHECK(basis.row_blocks[1].values[0] == 2);
  CHECK(basis.row_blocks[2].columns.empty());
  CHECK(basis.row_blocks[2].row_count == 3);
  CHECK(basis.value_count() == 2 * default_block_rows);
  CHECK_THROWS_AS(make_basis(rows, 3, dense), Error);
}

TEST_CASE("the closest name is looked for within a bound") {
  RigSchema schema;
  for (int i = 0; i < 300; ++i) schema.controls.push_back({std::to_string(i) + std::string(60000, 'n'), 0, 1, 0, ""});
  schema.controls.push_back({"jaw_open", 0, 1, 0, ""});
  CHECK(schema.closest("jaw_opne") == "jaw_open");
  CHECK(schema.closest(std::string(60000, 'm')).size() <= 60003);  // in hours without a bound
}

}  // namespace fb::test_model_types

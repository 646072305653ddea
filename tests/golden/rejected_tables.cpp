#include "golden_edits.h"

namespace fb {
namespace {

// A level of the smallest model with all vertices and without polygons; a coding of texture coordinates, and numbers of
// points and coefficients.
Bytes whole_level(std::uint32_t coding = 0, std::uint32_t points = 0, std::uint32_t coefficients = 0) {
  Bytes level = numbers({2, 0, 0, coding, 0, points});
  level.resize(level.size() + 6 * std::size_t(points));
  append(level, coefficients);
  level.resize(level.size() + (coefficients + 7) / 8);
  return level;
}

void write_rejected_whole_levels(const RejectedWriter& out) {
  const auto write = [&](const char* file, std::uint32_t count, const Bytes& level) {
    Bytes contents = numbers({count});
    for (std::uint32_t i = 0; i < count; ++i) contents.insert(contents.end(), level.begin(), level.end());
    out.replaced(file, "levels", contents, smallest());
  };
  write("corrupt-levels-16.fbk", 16, whole_level());
  write("corrupt-level-coding.fbk", 1, whole_level(2));
  write("corrupt-level-points.fbk", 1, whole_level(0, 1));
  write("corrupt-level-coefficients-more.fbk", 1, whole_level(0, 0, 1));
}

// Those of meshes begin at `meshes` with the number of meshes.
void write_rejected_level_meshes(const RejectedWriter& out, const PackedModel& model, std::size_t meshes) {
  // Two meshes, of two runs and of one.
  const std::size_t first = meshes + 4, first_run = first + 8, second = first_run + 16, second_run = second + 8;
  const auto shares = [&](const char* file, std::uint32_t of_first_run, std::uint32_t of_second) {
    const auto change = [&](Bytes& b) {
      patch(b, first, of_first_run + 1);
      patch(b, first_run, of_first_run);
      patch(b, second, of_second);
      patch(b, second_run, of_second);
    };
    out.write(file, changed("levels", change, model));
  };
  shares("corrupt-level-polygons-more.fbk", 2, 3);
  shares("corrupt-level-polygons-fewer.fbk", 2, 1);
  shares("corrupt-level-polygon-mesh.fbk", 3, 1);
  const auto add_run = [&](Bytes& b) {
    patch(b, first + 4, std::uint32_t(3));
    insert(b, first_run, {0, no_item});
  };
  out.write("corrupt-level-run-empty.fbk", changed("levels", add_run, model));
}

// One exact pose more than there may be, none of which corrects anything.
Bytes archive_of_1025_exact_poses() {
  constexpr std::uint32_t count = 1025;
  Bytes contents = numbers({count});
  for (std::uint32_t i = 0; i < count; ++i)  // named by 4 bytes that are not 0, at 1, of falloff 2 and step 1
    insert(contents, contents.size(), {4, 0x30303030 + i / 32 * 256 + i % 32, 0x3f800000, 0x40000000, 0x3f800000});
  contents.resize(contents.size() + count * 3 * 2 * 4);
  return edited(
      [&](ArchiveEditor& archive) {
        archive["exact-poses"].set(contents);
        deflate_section(archive["exact-poses"], 9);
      },
      smallest());
}

}  // namespace

void write_rejected_errors(const RejectedWriter& out) {
  const PackedModel model = character_model();
  const char* const name = "expected-errors";
  // After the unit and two regions, the number of runs, and a run of 8 bytes.
  constexpr std::size_t constant = 17, runs = 46, run = runs + 4;
  out.renamed("corrupt-error-nameless.fbk", name, "mouth", "", model);
  out.renamed("corrupt-error-names.fbk", name, "brows, upper left", "mouth", model);
  out.patched("corrupt-error-unit-infinite.fbk", name, 0, infinity, model);
  out.patched("corrupt-error-constant-infinite.fbk", name, constant, infinity, model);
  out.patched("corrupt-error-region-empty.fbk", name, run + 8 + 4, std::uint32_t(0), model);
  const auto add_run = [](Bytes& b) {
    patch(b, runs, std::uint32_t(4));
    insert(b, run, {0, 0});
  };
  out.write("corrupt-error-run-empty.fbk", changed(name, add_run, model));
  out.write("corrupt-expected-errors-more.fbk", changed(
                                                    name, [](Bytes& b) { b.resize(b.size() + 2); }, model));
  // Of one control: no pairs.
  const auto of_regions = [](std::uint32_t count) {
    Bytes contents = numbers({0x3f800000, count});
    for (std::uint32_t r = 0; r < count; ++r) insert(contents, contents.size(), {4, 0x30303030 + r, 0});
    append(contents, count);
    for (std::uint32_t r = 0; r < count; ++r) insert(contents, contents.size(), {1, r});
    contents.resize(contents.size() + count + 2);
    return contents;
  };
  PackedModel points = smallest();
  for (float x = 2; x < 65; ++x) points.rest.points.insert(points.rest.points.end(), {x, 0, 0});
  points.row_blocks = {{0, 3 * 65, {}, {}}};
  out.replaced("corrupt-errors-none.fbk", name, of_regions(0), points);
  out.replaced("corrupt-errors-65.fbk", name, of_regions(65), points);
}

void write_rejected_exact_poses(const RejectedWriter& out) {
  const PackedModel model = exact_model();
  const char* const name = "exact-poses";
  // Names take 4 + 8 and 4 + 7 bytes, controls 5 x 4, falloff and step 4 each.
  constexpr std::size_t controls = 4 + 12, falloff = controls + 20, step = falloff + 4, second = step + 4,
                        values = second + 11 + 20 + 8;
  out.write("corrupt-no-exact.fbk", changed(
                                        name, [](Bytes& b) { b.assign(4, {}); }, model));
  out.write("corrupt-exact-more.fbk", changed(
                                          name, [](Bytes& b) { b.resize(b.size() + 2); }, model));
  out.write("corrupt-exact-names.fbk", changed(
                                           name,
                                           [&](Bytes& b) {
                                             std::copy_n(b.begin() + 4, 12, b.begin() + second);
                                             b.insert(b.begin() + second + 12, b[second + 12]);
                                           },
                                           model));
  out.patched("corrupt-exact-control.fbk", name, controls, 1.5f, model);
  out.patched("corrupt-exact-falloff.fbk", name, falloff, 0.0f, model);
  out.patched("corrupt-exact-reach.fbk", name, falloff, 0x1p-10f, model);
  out.patched("corrupt-exact-step.fbk", name, step, std::uint32_t(0x7f800000), model);
  out.patched("corrupt-exact-value.fbk", name, values + 3 * 32, std::uint8_t(0x7f), model);
  out.patched("corrupt-exact-control-low.fbk", name, controls, -0.5f, model);
  out.patched("corrupt-exact-control-nan.fbk", name, controls, nan_bits, model);
  out.patched("corrupt-exact-falloff-infinite.fbk", name, falloff, infinity, model);
  out.patched("corrupt-exact-step-zero.fbk", name, step, 0.0f, model);
  out.renamed("corrupt-exact-nameless.fbk", name, "smile:12", "", model);
  out.write("corrupt-exact-short.fbk", changed(
                                           name, [](Bytes& b) { b.resize(b.size() - 4); }, model));
  out.write("corrupt-exact-1025.fbk", archive_of_1025_exact_poses());
  out.patched("unproven-exact.fbk", name, values + 7, std::uint8_t(0x7f), model);
}

void write_rejected_levels(const RejectedWriter& out) {
  const PackedModel model = levelled_model();
  // After the number of levels, the first has 3 numbers, 5 sizes and 19 corners and texture coordinates.
  constexpr std::size_t coding = 4 + 12 + 4 * 5 + 4 * 19, meshes = coding + 4 + 4 * 19,
                        points = meshes + 4 + 2 * 8 + 3 * 8, weights = points + 4 + 4 * 11,
                        coefficients = weights + 2 * 11;
  out.write("corrupt-no-levels.fbk", changed(
                                         "levels", [](Bytes& b) { b.assign(4, {}); }, model));
  out.write("corrupt-levels-more.fbk", changed(
                                           "levels", [](Bytes& b) { b.resize(b.size() + 2); }, model));
  out.patched("corrupt-level-vertices.fbk", "levels", 4, std::uint32_t(18), model);
  out.patched("corrupt-level-sizes.fbk", "levels", 16, std::uint8_t(5), model);
  out.patched("corrupt-level-corner.fbk", "levels", 16 + 4 * 5, std::uint8_t(8), model);
  out.patched("unsupported-level-uvs.fbk", "levels", coding, std::uint32_t(3), model);
  out.patched("corrupt-level-uvs.fbk", "levels", coding + 4, std::uint8_t(99), model);
  out.patched("corrupt-level-meshes.fbk", "levels", meshes + 4, std::uint32_t(2), model);
  out.patched("corrupt-level-material.fbk", "levels", meshes + 4 + 12, std::uint32_t(2), model);
  out.patched("corrupt-level-triangle.fbk", "levels", points + 4, std::uint8_t(99), model);
  out.patched("corrupt-level-point-mesh.fbk", "levels", points + 4, std::uint8_t(12), model);
  out.patched("corrupt-level-weights.fbk", "levels", weights + 11, std::uint8_t(200), model);
  out.patched("corrupt-level-coefficients.fbk", "levels", coefficients + 4, std::uint8_t(0), model);
  out.patched("corrupt-level-bits.fbk", "levels", coefficients + 4, std::uint8_t(11), model);
  out.patched("corrupt-level-vertices-none.fbk", "levels", 4, std::uint32_t(0), model);
  out.patched("corrupt-level-vertices-many.fbk", "levels", 4, std::uint32_t(32), model);
  const auto shrink_polygon = [](Bytes& b) {
    b[16 + 2] = std::byte(2);
    b[16 + 3] = std::byte(5);
  };
  out.write("corrupt-level-polygon-small.fbk", changed("levels", shrink_polygon, model));
  const auto drop_uvs = [](Bytes& b) {
    patch(b, coding, std::uint32_t(0));
    erase(b, coding + 4, 4 * 19);
  };
  out.write("corrupt-level-uvs-missing.fbk", changed("levels", drop_uvs, model));
  for (const char* section : {"uvs", "meshes", "materials"})
    out.write(format("corrupt-level-no-%s.fbk", section).c_str(), without(section, model));
  write_rejected_level_meshes(out, model, meshes);
  write_rejected_whole_levels(out);
  out.patched("unproven-level.fbk", "levels", weights, std::uint8_t(64), model);
  PackedModel other = model;
  other.character.sockets[0].vertices[0] = 0;
  out.patched("corrupt-level-socket.fbk", "sockets", 16, std::uint32_t(3), other);
}

}  // namespace fb

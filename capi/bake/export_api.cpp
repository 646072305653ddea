#include <facebaker/facebaker_export.h>

#include <nlohmann/json.hpp>

#include "bake/authoring.h"
#include "bake/baselines/skinning/skeleton.h"
#include "bake/export/onnx_face.h"
#include "base/checked.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

struct fb_decomposition {
  fb::Mesh rest;  // the surface alone
  fb::bake::Skeleton skeleton;
  std::vector<float> centres, weights;
  std::vector<std::uint16_t> joints;
};

namespace {

constexpr std::uint32_t most_joints = 1024;
constexpr std::uint32_t fitting_sweeps = 10;

fb::Mesh surface_of(const fb::Mesh& rest) {
  fb::Mesh surface = rest;
  surface.points.resize(3 * rest.surface_vertex_count());
  surface.carrier_vertices = 0;
  return surface;
}

std::span<const float> checked_positions(const float* positions, std::uint64_t poses, const fb::Mesh& rest) {
  const std::size_t size = fb::checked_multiply(poses, rest.points.size(), "positions");
  for (std::size_t i = 0; i < size; ++i)
    if (!std::isfinite(positions[i]))
      fail(Status::not_finite, "positions: pose %zu, vertex %zu is not finite", i / rest.points.size(),
           i % rest.points.size() / 3);
  return {positions, size};
}

// The arrays that hosts see: influences by falling weight.
void list_influences(fb_decomposition& made) {
  for (const auto& centre : made.skeleton.centres)
    made.centres.insert(made.centres.end(), centre.begin(), centre.end());
  for (std::size_t v = 0; v < made.skeleton.bones.size(); ++v) {
    std::array<std::size_t, fb::bake::bones_per_vertex> order = {0, 1, 2, 3};
    const auto& weights = made.skeleton.weights[v];
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return weights[a] > weights[b]; });
    for (const std::size_t k : order) {
      made.joints.push_back(static_cast<std::uint16_t>(made.skeleton.bones[v][k]));
      made.weights.push_back(weights[k]);
    }
  }
}

// A transform [A t] of a skeleton as rotation and origin.
void write_joint_frame(const float* transform, const std::array<float, 3>& centre, float* frame) {
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      frame[4 * row + column] = transform[4 * row + column] + (row == column ? 1.0f : 0.0f);
    frame[4 * row + 3] = centre[row] + transform[4 * row + 3];
  }
}

}  // namespace

extern "C" {

fb_status fb_export_onnx(const fb_archive* archive, const char* path, fb_report** report) {
  return abi_guard([&] {
    require(archive, "archive");
    require(path, "path");
    const fb::bake::OnnxTexts texts = {archive->contents.text.licence, fb_version_string()};
    const fb::bake::OnnxFace face = fb::bake::write_onnx(path, archive->contents.model, texts);
    auto made = std::make_unique<fb_report>();
    const nlohmann::ordered_json document = {{"file", path}, {"nodes", face.nodes}, {"parameters", face.parameters}};
    made->json = document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
    hand_over(std::move(made), report);
  });
}

void fb_decompose_desc_fill(fb_decompose_desc* to, uint32_t struct_size) {
  fb_decompose_desc defaults = {};
  defaults.joints = fb::bake::SkeletonOptions().bones;
  fill_struct(to, struct_size, defaults);
}

fb_status fb_decompose(const fb_decompose_desc* desc, fb_decomposition** decomposition) {
  return abi_guard([&] {
    require(desc, "desc");
    require(decomposition, "decomposition");
    const fb_decompose_desc known = read_struct(*desc, fb_decompose_desc_init, "fb_decompose_desc");
    require(known.archive, "fb_decompose_desc.archive");
    require(known.positions, "fb_decompose_desc.positions");
    if (known.poses == 0) fail(Status::invalid_argument, "fb_decompose_desc.poses: there are none");
    if (known.joints == 0 || known.joints > most_joints)
      fail(Status::invalid_argument, "fb_decompose_desc.joints: %u is not 1 to %u", known.joints, most_joints);
    HostProgress progress(known.callbacks);
    auto made = std::make_unique<fb_decomposition>();
    made->rest = surface_of(known.archive->contents.model.rest);
    const std::span<const float> points = checked_positions(known.positions, known.poses, made->rest);
    fb::bake::SkeletonOptions options;
    options.bones = known.joints;
    made->skeleton =
        fb::bake::extract_skeleton(made->rest, points, options, parallel_of(known.threads, &progress), progress);
    list_influences(*made);
    *decomposition = made.release();
  });
}

void fb_decomposition_free(fb_decomposition* decomposition) {
  delete decomposition;
}

void fb_decomposition_info_fill(fb_decomposition_info* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_decomposition_describe(const fb_decomposition* decomposition, fb_decomposition_info* info) {
  return abi_guard([&] {
    require(decomposition, "decomposition");
    const fb_decomposition& from = *decomposition;
    write_struct(
        info,
        {0, static_cast<std::uint32_t>(from.skeleton.bone_count()),
         static_cast<std::uint32_t>(fb::bake::bones_per_vertex), static_cast<std::uint32_t>(from.rest.vertex_count()),
         from.centres.data(), from.joints.data(), from.weights.data()},
        "fb_decomposition_info");
  });
}

fb_status fb_decomposition_fit(const fb_decomposition* decomposition, const float* positions, uint64_t poses,
                               uint32_t threads, float* frames) {
  return abi_guard([&] {
    require(decomposition, "decomposition");
    require(positions, "positions");
    require(frames, "frames");
    const fb_decomposition& from = *decomposition;
    const std::vector<float> transforms =
        fb::bake::fit_transforms(from.skeleton, from.rest, checked_positions(positions, poses, from.rest),
                                 fitting_sweeps, parallel_of(threads, nullptr));
    const std::size_t joints = from.skeleton.bone_count();
    for (std::size_t i = 0; i < poses * joints; ++i)
      write_joint_frame(&transforms[12 * i], from.skeleton.centres[i % joints], frames + 12 * i);
  });
}

}  // extern "C"

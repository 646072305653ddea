// Small faces defined by formulas, and helpers of the tests that bake them.
#pragma once

#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/evaluate.h"
#include "bake/pipeline/bake.h"
#include "memory_source.h"

struct WorkFolder {
  std::filesystem::path path;
  WorkFolder() {
    static int count = 0;
    path = std::filesystem::temp_directory_path() /
           ("fb_recipes_" + std::to_string(getpid()) + "_" + std::to_string(count++));
    std::filesystem::remove_all(path);
  }
  ~WorkFolder() { std::filesystem::remove_all(path); }
};

// A face with controls of different ranges; two have a rest value other than 0.
inline MemorySource face_of(const MemorySource::Formula& formula, bool live = false, std::size_t side = 8) {
  MemorySource source(4, side, formula, live);
  std::vector<fb::Control>& controls = source.edit_schema().controls;
  controls[1].minimum = 0, controls[1].maximum = 3, controls[1].rest = 1;
  controls[2].minimum = -4, controls[2].maximum = 0, controls[2].rest = -2;
  return source;
}

// The controls of face_of in units of their reach: -1 to 1 or less.
inline std::array<float, 4> shares(const float* c) {
  return {c[0], (c[1] - 1) / 2, (c[2] + 2) / 2, c[3]};
}

inline void linear_formula(const float* controls, std::span<float> points) {
  const auto c = shares(controls);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) points[i] += c[k] * (c[k] > 0 ? 0.5f : 0.2f) * std::sin(float(i * (k + 1)));
}

inline void curved_formula(const float* controls, std::span<float> points) {
  linear_formula(controls, points);
  const auto c = shares(controls);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += 0.6f * c[0] * c[1] * std::cos(0.3f * float(i));
}

// Excitations, dense poses, a training shot and a test shot of a face with a product corrective.
inline MemorySource curved_face() {
  MemorySource source = face_of(curved_formula);
  source.add_clip("dense", fb::bake::ClipKind::dense, fb::bake::Split::train, 200, 0.6f, 1);
  source.add_clip("shot", fb::bake::ClipKind::shot, fb::bake::Split::train, 56, 0.5f, 2);
  source.add_clip("validation", fb::bake::ClipKind::shot, fb::bake::Split::validation, 50, 0.5f, 3);
  source.add_clip("unseen", fb::bake::ClipKind::shot, fb::bake::Split::test, 200, 0.5f, 4);
  return source;
}

inline fb::bake::BakeOptions options_in(const WorkFolder& folder, const std::string& recipe = "paper") {
  fb::bake::BakeOptions options;
  options.recipe = recipe;
  options.epochs = 14;
  options.work = folder.path;
  return options;
}

inline double unseen_mse(const std::vector<std::byte>& archive, fb::bake::Source& source) {
  return fb::bake::evaluate_archive(archive, source, fb::bake::Split::test, {}, fb::silent_progress()).total.mse;
}

#include "tool_files.h"

#include <stdlib.h>

#include <algorithm>
#include <stdexcept>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/dataset/npy.h"
#include "base/file.h"
#include "runtime/evaluator.h"
#include "test_models.h"

ScratchFolder::ScratchFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "facebaker-test-XXXXXX").string();
  if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::filesystem::remove_all(path_);
}

std::vector<std::string> ScratchFolder::names() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(path_))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

fb::PackedModel write_tiny_archive(const std::string& path) {
  const auto bytes = fb::archive::write_archive(fb::tiny_packed_model(), {});
  fb::write_file(path, bytes);
  return fb::archive::read_archive(bytes).model;
}

std::vector<float> write_clip(const std::string& path, const fb::RigSchema& schema, std::size_t frames) {
  fb::Random random(7);
  std::vector<float> controls;
  for (std::size_t f = 0; f < frames; ++f) {
    const auto pose = fb::random_pose(schema, random);
    controls.insert(controls.end(), pose.begin(), pose.end());
  }
  fb::bake::write_npy(path, {frames, schema.control_count()}, std::span<const float>(controls));
  return controls;
}

std::vector<float> evaluate_clip(const fb::PackedModel& model, const std::vector<float>& controls) {
  const fb::runtime::Evaluator evaluator(model);
  fb::runtime::Workspace workspace(evaluator);
  const std::size_t frames = controls.size() / evaluator.control_count(), size = 3 * evaluator.vertex_count();
  std::vector<float> positions(frames * size);
  for (std::size_t f = 0; f < frames; ++f)
    evaluator.evaluate(&controls[f * evaluator.control_count()], &positions[f * size], workspace);
  return positions;
}

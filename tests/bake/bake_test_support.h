// What the tests of rig sources, datasets and sampling share.
#pragma once

#include <doctest/doctest.h>

#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bake/dataset/open_source.h"
#include "bake/sampling/active_sampling.h"
#include "bake/sampling/sampling.h"
#include "base/file.h"
#include "base/status.h"
#include "temporary_folder.h"

namespace fb::test {

inline bake::OpenedSource open_toy() {
  return bake::open_source(FB_TOY_RIG);
}

// The toy rig with one fault (faulty_rig.c lists them).
inline bake::OpenedSource open_faulty_rig(const char* fault) {
  setenv("FB_FAULT", fault, 1);
  return bake::open_source(FB_FAULTY_RIG);
}

// The sheet that does one thing no rig should (hostile_rig.cpp lists them).
inline bake::OpenedSource open_hostile_rig(const char* fault) {
  setenv("FB_FAULT", fault, 1);
  return bake::open_source(FB_HOSTILE_RIG);
}

// The message `work` fails with; fails the test if it does not fail with this status.
template <class Work>
std::string failure(Status status, Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    CHECK_MESSAGE(error.status() == status, error.what());
    return error.what();
  }
  FAIL("nothing failed");
  return "";
}

// What core/bake/sampling does with an evaluator, for a source that is evaluated in this one call only.
inline bake::PosePlan make_plan(bake::Source& source, const bake::SamplingOptions& options, const Parallel& parallel,
                                Progress& progress) {
  bake::RigEvaluator rig(source, parallel);
  return bake::make_plan(rig, options, progress);
}
inline bake::SampleReport sample_to_dataset(bake::Source& source, const bake::PosePlan& plan,
                                            const std::filesystem::path& folder, const Parallel& parallel,
                                            Progress& progress) {
  bake::RigEvaluator rig(source, parallel);
  return bake::sample_to_dataset(rig, plan, folder, progress);
}
inline bake::SampleReport sample(bake::Source& source, const bake::SamplingOptions& options,
                                 const std::filesystem::path& folder, const Parallel& parallel, Progress& progress) {
  bake::RigEvaluator rig(source, parallel);
  return bake::sample(rig, options, folder, progress);
}
inline bake::SampleReport extend_dataset(bake::Source& source, const std::vector<bake::Clip>& clips,
                                         const std::filesystem::path& folder, const Parallel& parallel,
                                         Progress& progress) {
  bake::RigEvaluator rig(source, parallel);
  return bake::extend_dataset(rig, clips, folder, progress);
}
inline bake::SampleReport sample_actively(bake::Source& source, const bake::SamplingOptions& options,
                                          const bake::ActiveSamplingOptions& choice,
                                          const bake::TrainEnsemble& ensemble, const std::filesystem::path& folder,
                                          const Parallel& parallel, Progress& progress) {
  bake::RigEvaluator rig(source, parallel);
  return bake::sample_actively(rig, options, choice, ensemble, folder, progress);
}

// The contents of all files of a folder, by name.
inline std::map<std::string, std::vector<std::byte>> files_of(const std::filesystem::path& folder) {
  std::map<std::string, std::vector<std::byte>> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files[entry.path().filename()] = read_file(entry.path());
  return files;
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace fb::test

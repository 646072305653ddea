// What the files of the authoring half share: its objects, progress, and the filling of structs.
#pragma once

#include <facebaker/facebaker_bake.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "abi_guard.h"
#include "archive/reader.h"
#include "bake/documents.h"
#include "bake/option_fields.h"
#include "bake/recipe/bake_options.h"
#include "bake/rig/source.h"
#include "bake/sampling/read_examples.h"
#include "base/calendar_day.h"
#include "base/parallel.h"
#include "base/progress.h"

struct fb_source {
  std::unique_ptr<fb::bake::Source> source;
  std::vector<std::filesystem::path> files;  // that it was opened from: of a folder, dataset.json
  std::string identity;                      // of fb_source_info
};

struct fb_archive {
  std::string name;  // stands for the path in reports
  std::vector<std::byte> bytes;
  fb::archive::Archive contents;
  std::string recipe, certificate_summary;
  std::vector<float> rest_controls;
};

namespace fb::capi {

// A folder for intermediate files, removed with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Passes progress and notes on to a host, one call at a time, and its wish to stop back.
class HostProgress final : public Progress {
 public:
  explicit HostProgress(const fb_callbacks& callbacks) : callbacks_(callbacks) {}

  void begin(Phase phase, std::string_view stage, std::uint64_t total) override;
  void update(std::uint64_t done) override;
  bool cancelled() const override { return cancelled_; }
  void note(std::string_view sentence) override;
  // Repeats the last report if it was a tenth of a second ago.
  void ask() override;

 private:
  void report(std::uint64_t done);  // with the lock held

  fb_callbacks callbacks_;
  std::mutex mutex_;
  std::string stage_ = "starting";  // until the first begins
  Phase phase_ = Phase::sampling;   // of the stage
  std::uint64_t done_ = 0, total_ = 0;
  std::atomic<std::chrono::steady_clock::rep> reported_ = 0;  // time of the last report
  std::atomic<bool> cancelled_ = false;
};

// Fails on more than 4,096. `progress` is asked between the items of loops; null: nobody is.
Parallel parallel_of(std::uint32_t threads, Progress* progress);

// The source of a description; fails naming the field unless there is one.
bake::Source& source_of(const fb_source* source, const char* field);

// The day of a text such as "2031-12-31"; today of null. Fails with invalid_argument on another text.
CalendarDay day_of(const char* on);

// Fails unless `use` is one of FB_USE_...
bake::Use use_of(std::int32_t use);
// "" of null.
inline std::string text_or_empty(const char* text) {
  return text ? text : "";
}

inline std::vector<std::byte> bytes_or_none(const void* bytes, std::uint64_t size) {
  const auto* first = static_cast<const std::byte*>(bytes);
  return first ? std::vector<std::byte>(first, first + size) : std::vector<std::byte>();
}

// What fb_bake_desc and fb_compare_desc, of this type, have in common.
template <class Desc>
bake::BakeOptions training_options(const Desc& desc, const char* type, Progress& progress) {
  bake::BakeOptions options;
  read_options(desc, type, options);
  read_named_options(desc.options, desc.option_count, type, options);
  options.parallel = parallel_of(desc.threads, &progress);
  options.work = text_or_empty(desc.work);
  return options;
}

// The files of poses that a description names.
template <class Desc>
std::vector<std::string> example_files(const Desc& desc) {
  std::vector<std::string> files;
  for (std::uint32_t i = 0; i < desc.example_count; ++i) {
    require(desc.examples, "examples");
    require(desc.examples[i], "one of examples");
    files.emplace_back(desc.examples[i]);
  }
  return files;
}

// The poses near which a live source is sampled, from these files; none for a recording.
template <class Desc>
std::vector<float> examples_of(const Desc& desc, const bake::Source& source, Progress& progress) {
  const std::vector<std::string> files = example_files(desc);
  return source.live() ? bake::read_examples(files, source, progress) : std::vector<float>();
}

fb_errors c_errors(const Errors& errors);

// Fills a caller's struct as far as its struct_size goes.
template <class Struct>
void write_struct(Struct* to, Struct full, const char* type) {
  require(to, type);
  require_size(to->struct_size, type);
  full.struct_size = to->struct_size;
  std::memcpy(static_cast<void*>(to), &full, std::min<std::size_t>(to->struct_size, sizeof full));
}

// An element of a caller's array whose elements may be longer than this header's.
template <class T>
const T& element(const T* array, std::uint32_t stride, std::size_t index) {
  return *reinterpret_cast<const T*>(reinterpret_cast<const std::byte*>(array) + index * stride);
}

}  // namespace fb::capi

struct fb_report {
  std::string json;
  std::optional<fb::capi::TemporaryFolder> folder;  // outlives the recording that lies in it
  fb::FaceFigures faces;
  fb::Errors quantisation;        // of fb_bake
  fb_source recorded;             // of fb_compare on a live rig
  std::string details;            // empty: not made yet
  std::vector<std::byte> packed;  // of fb_pack
  std::optional<fb_sample_result> sample;
  std::optional<fb_check_result> check;
  std::optional<fb_verify_result> verify;
  std::optional<fb_pack_result> pack;
  std::optional<fb_rights_result> rights;  // its strings are the next two
  std::string last_day, binding_rights;
  std::optional<fb_bag_result> bag;
};

namespace fb::capi {

// Hands a finished report to a caller who wants one.
inline void hand_over(std::unique_ptr<fb_report> report, fb_report** to) {
  if (to) *to = report.release();
}

}  // namespace fb::capi

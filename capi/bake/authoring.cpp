#include "bake/authoring.h"

#include <cstdlib>
#include <system_error>

#include "base/shown_path.h"
#include "base/status.h"
#include "base/visible_text.h"

namespace fb::capi {

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "facebaker-XXXXXX").string();
  if (!mkdtemp(pattern.data())) fail(Status::io, "%s: cannot be made", shown(pattern).c_str());
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

namespace {

thread_local std::int32_t told_phase = FB_PHASE_SAMPLING;  // of the last call of a host's progress

}  // namespace

void HostProgress::begin(Phase phase, std::string_view stage, std::uint64_t total) {
  static_assert(static_cast<int>(Phase::writing) == FB_PHASE_WRITING);
  const std::lock_guard lock(mutex_);
  phase_ = phase;
  stage_ = stage;
  total_ = total;
  report(0);
}

void HostProgress::update(std::uint64_t done) {
  const std::lock_guard lock(mutex_);
  report(done);
}

void HostProgress::ask() {
  const std::chrono::steady_clock::duration last(reported_);
  if (std::chrono::steady_clock::now().time_since_epoch() - last >= std::chrono::milliseconds(100)) {
    const std::lock_guard lock(mutex_);
    report(done_);
  }
  Progress::ask();
}

void HostProgress::report(std::uint64_t done) {
  done_ = done;
  reported_ = std::chrono::steady_clock::now().time_since_epoch().count();
  told_phase = static_cast<std::int32_t>(phase_);
  if (callbacks_.progress && callbacks_.progress(callbacks_.user, stage_.c_str(), done, total_) != 0) cancelled_ = true;
}

void HostProgress::note(std::string_view sentence) {
  const std::lock_guard lock(mutex_);
  if (callbacks_.note) callbacks_.note(callbacks_.user, visible_text(sentence, Layout::kept).c_str());
}

Parallel parallel_of(std::uint32_t threads, Progress* progress) {
  if (threads > 4096) fail(Status::invalid_argument, "%u threads", threads);
  return {.threads = static_cast<int>(threads), .progress = progress};
}

bake::Source& source_of(const fb_source* source, const char* field) {
  require(source, field);
  return *source->source;
}

bake::Use use_of(std::int32_t use) {
  if (use != FB_USE_VARIANT && use != FB_USE_BACKLOT)
    fail(Status::invalid_argument, "use %d is neither FB_USE_VARIANT nor FB_USE_BACKLOT", use);
  return use == FB_USE_VARIANT ? bake::Use::variant : bake::Use::backlot;
}

fb_errors c_errors(const Errors& errors) {
  return {errors.frames, errors.mse, errors.rms, errors.mean, errors.p99, errors.max, errors.mfm, errors.worst_frame};
}

CalendarDay day_of(const char* on) {
  if (!on) return today();
  const std::optional<CalendarDay> day = calendar_day_in(on);
  if (!day) fail(Status::invalid_argument, "%s is no day as in 2031-12-31", shown(on).c_str());
  return *day;
}

}  // namespace fb::capi

extern "C" int32_t fb_progress_phase(void) {
  return fb::capi::told_phase;
}

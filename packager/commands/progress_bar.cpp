#include "commands/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>

#include "base/status.h"
#include "commands/interrupt.h"

namespace fb::tool {
namespace {

constexpr auto redraw_interval = std::chrono::milliseconds(100);
constexpr auto line_interval = std::chrono::seconds(15);
constexpr int bar_cells = 28;
constexpr const char* clear_line = "\r\033[K";

double seconds_between(std::chrono::steady_clock::time_point from, std::chrono::steady_clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

fb_callbacks collect_notes(std::vector<std::string>& notes) {
  fb_callbacks callbacks = {};
  callbacks.user = &notes;
  callbacks.note = [](void* user, const char* sentence) {
    static_cast<std::vector<std::string>*>(user)->emplace_back(sentence);
  };
  return callbacks;
}

std::string duration_text(double seconds) {
  const auto whole = static_cast<unsigned long long>(std::max(seconds, 0.0) + 0.5);
  if (whole < 60) return format("%llu s", whole);
  if (whole < 3600) return format("%llu:%02llu", whole / 60, whole % 60);
  return format("%llu:%02llu:%02llu", whole / 3600, whole / 60 % 60, whole % 60);
}

ProgressBar::ProgressBar() : terminal_(::isatty(STDERR_FILENO)), exceptions_(std::uncaught_exceptions()) {}

ProgressBar::~ProgressBar() {
  if (std::uncaught_exceptions() == exceptions_)
    finish_stage();
  else if (terminal_ && !stage_.empty())
    std::fputs(clear_line, stderr);
}

void ProgressBar::begin(std::string_view stage, std::uint64_t total) {
  const std::lock_guard lock(mutex_);
  finish_stage();
  stage_ = stage;
  total_ = total;
  done_ = 0;
  counting_ = false;
  start_ = Clock::now();
  next_draw_ = start_ + (terminal_ ? Clock::duration(redraw_interval) : Clock::duration(line_interval));
}

void ProgressBar::update(std::uint64_t done) {
  const std::lock_guard lock(mutex_);
  if (stage_.empty()) return;
  done_ = std::min(done, total_);
  const auto now = Clock::now();
  if (!counting_) {
    counting_ = true;
    start_done_ = done_ > 1 ? done_ : 0;
  }
  if (now >= next_draw_) draw(now);
}

bool ProgressBar::cancelled() const {
  return interrupt_requested();
}

void ProgressBar::note(std::string_view sentence) {
  const std::lock_guard lock(mutex_);
  if (done_ == total_) finish_stage();
  std::fprintf(stderr, "%snote: %.*s\n", terminal_ ? clear_line : "", static_cast<int>(sentence.size()),
               sentence.data());
}

fb_callbacks ProgressBar::callbacks() {
  fb_callbacks callbacks = {};
  callbacks.user = this;
  callbacks.progress = [](void* user, const char* stage, std::uint64_t done, std::uint64_t total) -> std::int32_t {
    ProgressBar& bar = *static_cast<ProgressBar*>(user);
    if (bar.begins(stage, done))
      bar.begin(stage, total);
    else
      bar.update(done);
    return bar.cancelled();
  };
  callbacks.note = [](void* user, const char* sentence) { static_cast<ProgressBar*>(user)->note(sentence); };
  return callbacks;
}

// Whether a call of the C callback begins a stage: it does so with done = 0, also for a second stage of the same name.
bool ProgressBar::begins(std::string_view stage, std::uint64_t done) {
  const std::lock_guard lock(mutex_);
  return stage != stage_ || (done == 0 && done_ > 0);
}

void ProgressBar::draw(Clock::time_point now) {
  const double elapsed = seconds_between(start_, now);
  const double share = total_ ? static_cast<double>(done_) / total_ : 0;
  std::string left;
  if (done_ > start_done_)
    left = duration_text(elapsed * (total_ - done_) / static_cast<double>(done_ - start_done_)) + " left";
  if (terminal_) {
    const int full = static_cast<int>(share * bar_cells);
    const std::string bar = std::string(full, '#') + std::string(bar_cells - full, '.');
    std::fprintf(stderr, "%s%s [%s] %3.0f %%  %s", clear_line, stage_.c_str(), bar.c_str(), 100 * share, left.c_str());
    std::fflush(stderr);
    next_draw_ = now + redraw_interval;
  } else {
    std::fprintf(stderr, "%s: %.0f %%%s%s\n", stage_.c_str(), 100 * share, left.empty() ? "" : ", ", left.c_str());
    next_draw_ = now + line_interval;
  }
}

void ProgressBar::finish_stage() {
  if (stage_.empty()) return;
  std::fprintf(stderr, "%s%s: %s\n", terminal_ ? clear_line : "", stage_.c_str(),
               duration_text(seconds_between(start_, Clock::now())).c_str());
  stage_.clear();
}

}  // namespace fb::tool

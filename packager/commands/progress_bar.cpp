#include "commands/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>

#include "base/status.h"
#include "base/visible_text.h"
#include "commands/interrupt.h"
#include "commands/terminal.h"

namespace fb::tool {
namespace {

constexpr auto redraw_interval = std::chrono::milliseconds(100);
constexpr auto line_interval = std::chrono::seconds(15);
constexpr std::size_t most_cells = 28, least_cells = 5;  // of a bar
constexpr std::size_t usual_width = 80;                  // where a terminal does not tell
constexpr double short_rest = 20;                        // seconds: of less, no more is told
constexpr double least_worked = 0.05;                    // of a stage before how long a bake takes is estimated
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

ProgressBar::ProgressBar(Work work)
    : terminal_(::isatty(STDERR_FILENO)),
      coloured_(takes_colour(STDERR_FILENO)),
      exceptions_(std::uncaught_exceptions()) {
  if (work != Work::other) phases_.emplace(work == Work::bake_with_report);
}

ProgressBar::~ProgressBar() {
  if (std::uncaught_exceptions() != exceptions_) {
    if (terminal_ && !stage_.empty()) std::fputs(clear_line, stderr);
    return;
  }
  try {
    const bool whole = phases_ && !stage_.empty();
    finish_stage();
    if (whole) print_line(duration_text(seconds_between(begin_, Clock::now())), "in all: ");
  } catch (...) {  // no memory for a line that nothing depends on
  }
}

void ProgressBar::begin(Phase phase, std::string_view stage, std::uint64_t total) {
  const std::lock_guard lock(mutex_);
  const bool first = part_.empty();
  const bool fresh = phases_ ? phases_->begin(phase, stage) : stage != stage_;
  part_ = stage;
  total_ = total;
  done_ = 0;
  counting_ = false;
  if (!fresh) return;
  finish_stage();
  stage_ = phases_ ? phases_->name() : visible_text(part_, Layout::hidden);
  start_ = Clock::now();
  if (first) begin_ = start_;
  next_draw_ = start_ + (terminal_ ? Clock::duration(redraw_interval) : Clock::duration(line_interval));
}

void ProgressBar::update(std::uint64_t done) {
  const std::lock_guard lock(mutex_);
  if (stage_.empty()) return;
  done_ = std::min(done, total_);
  if (phases_) phases_->update(total_ ? static_cast<double>(done_) / static_cast<double>(total_) : 0);
  const auto now = Clock::now();
  if (!counting_) {
    counting_ = true;
    start_done_ = done_ > 1 ? done_ : 0;
    count_start_ = now;
  }
  if (now >= next_draw_) draw(now);
}

bool ProgressBar::cancelled() const {
  return interrupt_requested();
}

void ProgressBar::note(std::string_view sentence) {
  const std::lock_guard lock(mutex_);
  if (done_ == total_ && !phases_) finish_stage();
  const Colour colour = sentence.starts_with("warning") ? Colour::warning : Colour::heading;
  print_line(sentence, (terminal_ ? clear_line : "") + in_colour(colour, "note:", coloured_) + " ");
}

fb_callbacks ProgressBar::callbacks() {
  fb_callbacks callbacks = {};
  callbacks.user = this;
  callbacks.progress = [](void* user, const char* stage, std::uint64_t done, std::uint64_t total) -> std::int32_t {
    ProgressBar& bar = *static_cast<ProgressBar*>(user);
    if (bar.begins(stage, done))
      bar.begin(static_cast<Phase>(fb_progress_phase()), stage, total);
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
  return stage != part_ || stage_.empty() || (done == 0 && done_ > 0);
}

// Of what is told, 0 to 1.
double ProgressBar::share() const {
  if (phases_) return phases_->done();
  return total_ ? static_cast<double>(done_) / static_cast<double>(total_) : 0;
}

// "2:07 left"; "" if nothing can be said yet.
std::string ProgressBar::time_left(Clock::time_point now) {
  if (done_ <= start_done_) return {};
  const auto worked = static_cast<double>(done_ - start_done_), more = static_cast<double>(total_ - done_);
  const double left = seconds_between(count_start_, now) * more / worked;
  if (!phases_) return duration_text(left) + " left";
  if (worked < least_worked * static_cast<double>(total_)) return {};
  const std::optional<double> whole = phases_->seconds_left(left, seconds_between(begin_, now));
  if (!whole) return {};
  return (*whole < short_rest ? "less than " + duration_text(short_rest) : "about " + duration_text(*whole)) + " left";
}

void ProgressBar::draw(Clock::time_point now) {
  const std::string left = time_left(now);
  if (!terminal_) {
    std::fprintf(stderr, "%s: %.0f %%%s%s\n", stage_.c_str(), 100 * share(), left.empty() ? "" : ", ", left.c_str());
    next_draw_ = now + line_interval;
    return;
  }
  std::size_t width = terminal_width(STDERR_FILENO);
  if (width == 0) width = usual_width;
  --width;  // in the last column, terminals begin a new line
  const std::string percent = format(" %3.0f %%", 100 * share());
  std::string end = percent + "  " + left;
  if (stage_.size() + end.size() > width) end = percent;
  const std::string name = cut_to_width(stage_, width - std::min(end.size(), width));
  const std::size_t taken = name.size() + end.size() + 3;  // " []"
  const std::size_t cells = width > taken ? std::min(width - taken, most_cells) : 0;
  std::string bar;
  if (cells >= least_cells) {
    const auto full = static_cast<std::size_t>(share() * static_cast<double>(cells));
    bar = " [" + std::string(full, '#') + std::string(cells - full, '.') + "]";
  }
  std::fprintf(stderr, "%s%s", clear_line, cut_to_width(name + bar + end, width).c_str());
  std::fflush(stderr);
  next_draw_ = now + redraw_interval;
}

void ProgressBar::finish_stage() {
  if (stage_.empty()) return;
  std::fprintf(stderr, "%s%s: %s\n", terminal_ ? clear_line : "", stage_.c_str(),
               duration_text(seconds_between(start_, Clock::now())).c_str());
  stage_.clear();
}

}  // namespace fb::tool

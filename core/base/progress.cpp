#include "base/progress.h"

#include "base/status.h"

namespace fb {

void Progress::step(std::uint64_t done) {
  update(done);
  Progress::ask();
}

void Progress::ask() {
  if (cancelled()) fail(Status::interrupted, "interrupted; what is done so far is kept");
}

Progress& silent_progress() {
  struct Silent final : Progress {
    void begin(Phase, std::string_view, std::uint64_t) override {}
    void update(std::uint64_t) override {}
    bool cancelled() const override { return false; }
    void note(std::string_view) override {}
  };
  static Silent silent;
  return silent;
}

}  // namespace fb

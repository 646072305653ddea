// A child that serves the toy rig over the rig protocol, with the fault that its argument names. The marked pose is the
// one in which browTwist is -0.5.
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "bake/dataset/open_source.h"
#include "bake/rig_process/rig_host.h"
#include "bake/rig_process/rig_messages.h"

using namespace fb;
using namespace fb::bake;

namespace {

class FaultySource final : public Source {
 public:
  FaultySource(OpenedSource rig, std::string fault) : rig_(std::move(rig)), fault_(std::move(fault)) {
    schema_ = rig_->schema();
    if (fault_ == "another") schema_.name = std::to_string(getpid());
  }
  const RigSchema& schema() const override { return schema_; }
  const Mesh& rest() const override { return rig_->rest(); }
  const std::vector<Clip>& clips() const override { return rig_->clips(); }
  bool live() const override { return true; }
  std::size_t preferred_block() const override { return fault_ == "prefers 7" ? 7 : 0; }
  std::string version() const override { return fault_ == "version" ? "12b" : ""; }
  void read(std::size_t, std::size_t, std::size_t, std::span<float>) override {}

  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override {
    const std::size_t width = schema_.control_count();
    if (fault_ == "prints") std::printf("evaluating %zu poses\n", count), std::fflush(stdout);
    if (fault_ == "prefers 7" && count > 7) throw PoseError(Status::rig, 0, "too many poses");
    if (fault_ == "hangs at rest") pause();
    for (std::size_t i = 0; i < count; ++i) {
      if (fault_ == "slow") std::this_thread::sleep_for(std::chrono::milliseconds(100));
      if (controls[i * width + 1] != -0.5f) continue;
      if (fault_ == "crashes") raise(SIGKILL);
      if (fault_ == "exits") std::_Exit(3);
      if (fault_ == "hangs") pause();
      if (fault_ == "another") std::_Exit(3);
      if (fault_ == "fails") throw PoseError(Status::rig, i, "the twist solver did not converge");
      if (fault_ == "fails without number") fail(Status::rig, "out of licences");
    }
    rig_->evaluate(controls, count, points);
    for (std::size_t i = 0; i < count; ++i)
      if (fault_ == "nan" && controls[i * width + 1] == -0.5f) points[i * rest().points.size() + 4] = 0.0f / 0.0f;
  }

 private:
  OpenedSource rig_;
  std::string fault_;
  RigSchema schema_;
};

void write_all(const std::vector<std::byte>& bytes) {
  if (::write(rig_answers_descriptor, bytes.data(), bytes.size()) < 0) std::_Exit(1);
}

// What lies in another way than a rig can; true if that is all there is to say.
bool lies(const Source& rig, const std::string& fault) {
  RigMessage hello = hello_answer(rig);
  const auto changed = [&](const std::string& from, const std::string& to) {
    hello.text.replace(hello.text.find(from), from.size(), to);
    write_all(bytes_of(hello));
  };
  if (fault == "says nothing") return pause(), true;
  if (fault == "ends at once") return true;
  if (fault == "writes text") return std::fflush(stdout), dprintf(rig_answers_descriptor, "Hello! I am a rig.\n"), true;
  if (fault == "claims much data" || fault == "claims much text") {
    std::vector<std::byte> bytes = bytes_of(hello);
    bytes[fault == "claims much data" ? 14 : 7] = std::byte{0xff};
    write_all(bytes);
  } else if (fault == "is cut off") {
    std::vector<std::byte> bytes = bytes_of(hello);
    bytes.resize(bytes.size() - 5);
    write_all(bytes);
    return true;
  } else if (fault == "claims vertices") {
    changed("\"vertices\":50", "\"vertices\":4000000000");
  } else if (fault == "claims few vertices") {
    changed("\"vertices\":50", "\"vertices\":49");
  } else if (fault == "is of another version") {
    changed("\"version\":1", "\"version\":2");
  } else if (fault == "has no name") {
    changed("\"name\":", "\"game\":");
  } else if (fault == "is no JSON") {
    changed("{", "[");
  } else {
    return false;
  }
  pause();
  return true;
}

}  // namespace

int main(int count, char** arguments) {
  const std::string fault = count > 1 ? arguments[1] : "";
  FaultySource rig(open_source(FB_TOY_RIG), fault);
  if (lies(rig, fault)) return 0;
  try {
    if (fault == "refuses")
      refuse_to_serve("the licence server is asleep", rig_answers_descriptor);
    else
      serve_rig(rig, rig_requests_descriptor, rig_answers_descriptor);
  } catch (const Error& error) {
    std::fprintf(stderr, "rig_child: %s\n", error.what());
    return 1;
  }
  return 0;
}

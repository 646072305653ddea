#include "capture/capture_reader.h"

#include <functional>
#include <map>
#include <set>
#include <string_view>

#include "base/status.h"
#include "capture/live_link_face.h"
#include "capture/vmc_capture.h"

namespace fb::tool {
namespace {

constexpr std::size_t most_names = 1024;

class LiveLinkReader final : public CaptureReader {
 public:
  LiveLinkReader() {
    names_.assign(live_link_names.begin(), live_link_names.end());
    values_.resize(names_.size());
  }

  bool take(std::span<const std::byte> packet) override {
    const LiveLinkFacePacket read = parse_live_link_face(packet);
    subject_ = read.subject;
    if (read.has_face) values_.assign(read.values.begin(), read.values.end());
    return read.has_face;
  }
};

class VmcReader final : public CaptureReader {
 public:
  bool take(std::span<const std::byte> packet) override {
    const std::vector<VmcValue> read = parse_vmc(packet);
    std::set<std::string_view> added;
    for (const VmcValue& value : read)
      if (!value.name.empty() && !indices_.contains(value.name)) added.insert(value.name);
    if (names_.size() + added.size() > most_names) fail(Status::limit, "there are more than %zu names", most_names);
    bool applied = false;
    for (const VmcValue& value : read) {
      if (value.name.empty()) {
        values_ = coming_;
        applied = true;
      } else {
        coming_[index_of(value.name)] = value.value;
      }
    }
    return applied;
  }

 private:
  std::size_t index_of(std::string_view name) {
    const auto [found, is_new] = indices_.emplace(name, names_.size());
    if (is_new) {
      names_.emplace_back(name);
      coming_.push_back(0);
      values_.push_back(0);
    }
    return found->second;
  }

  std::map<std::string, std::size_t, std::less<>> indices_;
  std::vector<float> coming_;  // of the frame that is being sent
};

}  // namespace

const char* name_of(CaptureProtocol protocol) {
  return protocol == CaptureProtocol::live_link ? "Live Link Face" : "VMC";
}

int usual_port(CaptureProtocol protocol) {
  return protocol == CaptureProtocol::live_link ? 11111 : 39539;
}

std::unique_ptr<CaptureReader> make_capture_reader(CaptureProtocol protocol) {
  if (protocol == CaptureProtocol::live_link) return std::make_unique<LiveLinkReader>();
  return std::make_unique<VmcReader>();
}

}  // namespace fb::tool

#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace fb::tool {

enum class CaptureProtocol { live_link, vmc };

// "Live Link Face", "VMC".
const char* name_of(CaptureProtocol protocol);
// The UDP port that senders of the protocol have as their default.
int usual_port(CaptureProtocol protocol);

// What the packets of one sender say, by name.
class CaptureReader {
 public:
  virtual ~CaptureReader() = default;

  // Takes a packet. Whether values() are those of another frame now. Fails with bad_data, not_finite or limit on what
  // is no packet of the protocol; nothing of that is taken.
  virtual bool take(std::span<const std::byte> packet) = 0;

  // Those known so far, which only grow, and a value of each, finite; 0 for what has not come.
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<float>& values() const { return values_; }
  // What the sender calls itself; "" where the protocol does not say.
  const std::string& subject() const { return subject_; }

 protected:
  std::vector<std::string> names_;
  std::vector<float> values_;
  std::string subject_;
};

std::unique_ptr<CaptureReader> make_capture_reader(CaptureProtocol protocol);

}  // namespace fb::tool

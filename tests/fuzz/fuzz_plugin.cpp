// A rig that lies: whatever a plugin can put into the structs of facebaker_rig.h without breaking the promise that
// pointers point to what the counts say.
#include <cstring>
#include <list>
#include <string>
#include <vector>

#include "bake/rig/rig_source.h"
#include "base/status.h"

namespace {

// Takes numbers from the input; 0 once it is used up.
class Input {
 public:
  Input(const unsigned char* data, std::size_t size) : data_(data), size_(size) {}
  template <class T>
  T number() {
    T value{};
    const std::size_t taken = std::min(sizeof value, size_);
    std::memcpy(&value, data_, taken);
    data_ += taken;
    size_ -= taken;
    return value;
  }
  std::uint32_t below(std::uint32_t count) { return number<std::uint8_t>() % count; }

 private:
  const unsigned char* data_;
  std::size_t size_;
};

struct LyingRig {
  std::list<std::string> texts;
  std::vector<fb_rig_control> controls;
  std::vector<float> rest, moved;
  std::vector<std::uint32_t> sizes, corners;
  std::vector<std::vector<float>> clip_controls;
  std::vector<fb_rig_clip> clips;
  fb_status status = 0;
  std::uint8_t terminated = 1;

  const char* text(Input& in) {
    const std::uint32_t length = in.below(8);
    if (length == 7) return nullptr;
    std::string& text = texts.emplace_back();
    for (std::uint32_t i = 0; i < length; ++i) text.push_back(static_cast<char>(in.number<std::uint8_t>()));
    return text.c_str();
  }

  static fb_status evaluate(void* user, uint64_t poses, const float*, float* positions, char* message,
                            uint32_t message_size) {
    const auto& rig = *static_cast<const LyingRig*>(user);
    for (uint64_t pose = 0; pose < poses; ++pose)
      std::copy(rig.moved.begin(), rig.moved.end(), positions + pose * rig.moved.size());
    if (message_size > 0) std::memset(message, 'x', message_size);
    if (message_size > 0 && rig.terminated) message[message_size - 1] = 0;
    return rig.status;
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  Input in(data, size);
  LyingRig lie;
  fb_rig rig{};
  const std::uint8_t oddities = in.number<std::uint8_t>();
  rig.struct_size = oddities & 1 ? in.number<std::uint32_t>() : sizeof rig;
  rig.control_stride = sizeof(fb_rig_control);
  rig.clip_stride = sizeof(fb_rig_clip);
  rig.abi = oddities & 2 ? in.number<std::uint32_t>() : FB_RIG_ABI;
  rig.flags = in.number<std::uint8_t>();
  rig.name = lie.text(in);
  rig.units = lie.text(in);
  rig.up_axis = oddities & 4 ? lie.text(in) : "y";
  lie.terminated = !(oddities & 8);
  lie.status = oddities & 16 ? in.number<std::int32_t>() : 0;
  for (std::uint32_t c = in.below(5); c > 0; --c) {
    const char *name = lie.text(in), *group = lie.text(in);
    const float low = in.number<float>(), high = in.number<float>(), rest = in.number<float>();
    lie.controls.push_back({name, group, low, high, rest, 0});
  }
  for (std::uint32_t v = 3 * in.below(6); v > 0; --v) lie.rest.push_back(in.number<float>());
  lie.moved = lie.rest;
  if (oddities & 32)
    for (float& x : lie.moved) x = in.number<float>();
  for (std::uint32_t p = in.below(5); p > 0; --p) {
    lie.sizes.push_back(in.below(6));
    for (std::uint32_t k = 0; k < lie.sizes.back(); ++k)
      lie.corners.push_back(oddities & 64 ? in.number<std::uint32_t>() : in.below(6));
  }
  for (std::uint32_t n = in.below(4); n > 0; --n) {
    const std::uint32_t frames = in.below(4);
    std::vector<float>& values = lie.clip_controls.emplace_back();
    for (std::size_t i = 0; i < frames * lie.controls.size(); ++i) values.push_back(in.number<float>());
    const char* name = lie.text(in);
    const std::int32_t kind = in.below(7), split = in.below(5);
    lie.clips.push_back({name, kind, split, in.number<double>(), frames, 0, nullptr});
  }
  for (std::size_t n = 0; n < lie.clips.size(); ++n) lie.clips[n].controls = lie.clip_controls[n].data();
  rig.control_count = static_cast<std::uint32_t>(lie.controls.size());
  rig.controls = lie.controls.data();
  rig.vertex_count = static_cast<std::uint32_t>(lie.rest.size() / 3);
  rig.rest_positions = lie.rest.data();
  rig.polygon_count = static_cast<std::uint32_t>(lie.sizes.size());
  rig.polygon_sizes = lie.sizes.data();
  rig.polygon_corners = lie.corners.data();
  rig.clip_count = static_cast<std::uint32_t>(lie.clips.size());
  rig.clips = lie.clips.data();
  rig.user = &lie;
  rig.evaluate = oddities & 128 ? nullptr : &LyingRig::evaluate;
  try {
    fb::bake::RigSource source(rig);
    std::vector<float> pose(source.schema().control_count()), points(source.rest().points.size());
    for (std::size_t c = 0; c < pose.size(); ++c) pose[c] = source.schema().controls[c].maximum;
    source.evaluate(pose, 1, points);
    for (std::size_t clip = 0; clip < source.clips().size(); ++clip) source.read(clip, 0, 1, points);
  } catch (const fb::Error& error) {
    if (std::strlen(error.what()) < 10) __builtin_trap();
  }
  return 0;
}

// Feeds forged rigs to RigSource: arbitrary contents of the structs of facebaker_rig.h, except that pointers are valid
// for their counts.
#include <cstring>
#include <list>
#include <string>
#include <vector>

#include "bake/rig/rig_source.h"
#include "base/status.h"

namespace {

// Reads numbers from the input; 0 at its end.
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

// A rig and the arrays it points to. The order in which members are read from the input is fixed by the corpus.
struct ForgedRig {
  fb_rig rig{};
  std::uint8_t oddities = 0;  // bits: which members are arbitrary
  std::list<std::string> texts;
  std::vector<fb_rig_control> controls;
  std::vector<float> rest, evaluated;
  std::vector<std::uint32_t> sizes, corners;
  std::vector<std::vector<float>> clip_controls;
  std::vector<fb_rig_clip> clips;
  std::vector<fb_joint> joints;
  std::vector<std::uint16_t> skin_joints;
  std::vector<float> skin_weights, frames;  // frames: of joints, in every pose
  std::vector<std::uint32_t> joint_numbers;
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
    const auto& self = *static_cast<const ForgedRig*>(user);
    for (uint64_t pose = 0; pose < poses; ++pose)
      std::copy(self.evaluated.begin(), self.evaluated.end(), positions + pose * self.evaluated.size());
    if (message_size > 0) std::memset(message, 'x', message_size);
    if (message_size > 0 && self.terminated) message[message_size - 1] = 0;
    return self.status;
  }

  static fb_status evaluate_skinned(void* user, uint64_t poses, const float* controls, float* positions, float*,
                                    float* joints, char* message, uint32_t message_size) {
    const auto& self = *static_cast<const ForgedRig*>(user);
    for (uint64_t pose = 0; pose < poses; ++pose)
      std::copy(self.frames.begin(), self.frames.end(), joints + pose * self.frames.size());
    return evaluate(user, poses, controls, positions, message, message_size);
  }

  void read_header(Input& in) {
    oddities = in.number<std::uint8_t>();
    rig.struct_size = oddities & 1 ? in.number<std::uint32_t>() : sizeof rig;
    rig.control_stride = sizeof(fb_rig_control);
    rig.clip_stride = sizeof(fb_rig_clip);
    rig.abi = oddities & 2 ? in.number<std::uint32_t>() : FB_RIG_ABI;
    rig.flags = in.number<std::uint8_t>();
    rig.name = text(in);
    rig.units = text(in);
    rig.up_axis = oddities & 4 ? text(in) : "y";
    terminated = !(oddities & 8);
    status = oddities & 16 ? in.number<std::int32_t>() : 0;
  }

  void read_controls(Input& in) {
    for (std::uint32_t c = in.below(5); c > 0; --c) {
      const char *name = text(in), *group = text(in);
      const float low = in.number<float>(), high = in.number<float>(), at_rest = in.number<float>();
      controls.push_back({name, group, low, high, at_rest, 0});
    }
    rig.control_count = static_cast<std::uint32_t>(controls.size());
    rig.controls = controls.data();
  }

  void read_mesh(Input& in) {
    for (std::uint32_t v = 3 * in.below(6); v > 0; --v) rest.push_back(in.number<float>());
    evaluated = rest;
    if (oddities & 32)
      for (float& x : evaluated) x = in.number<float>();
    for (std::uint32_t p = in.below(5); p > 0; --p) {
      sizes.push_back(in.below(6));
      for (std::uint32_t k = 0; k < sizes.back(); ++k)
        corners.push_back(oddities & 64 ? in.number<std::uint32_t>() : in.below(6));
    }
    rig.vertex_count = static_cast<std::uint32_t>(rest.size() / 3);
    rig.rest_positions = rest.data();
    rig.polygon_count = static_cast<std::uint32_t>(sizes.size());
    rig.polygon_sizes = sizes.data();
    rig.polygon_corners = corners.data();
  }

  void read_clips(Input& in) {
    for (std::uint32_t n = in.below(4); n > 0; --n) {
      const std::uint32_t frames = in.below(4);
      std::vector<float>& values = clip_controls.emplace_back();
      for (std::size_t i = 0; i < frames * controls.size(); ++i) values.push_back(in.number<float>());
      const char* name = text(in);
      const std::int32_t kind = in.below(7), split = in.below(5);
      clips.push_back({name, kind, split, in.number<double>(), frames, 0, nullptr});
    }
    for (std::size_t n = 0; n < clips.size(); ++n) clips[n].controls = clip_controls[n].data();
    rig.clip_count = static_cast<std::uint32_t>(clips.size());
    rig.clips = clips.data();
  }

  // None where the input has ended.
  void read_joints(Input& in) {
    const auto read_frame = [&](float* to) {  // the identity, and what the input adds to it
      for (std::size_t i = 0; i < FB_FRAME_FLOATS; ++i) to[i] = in.number<float>() + (i % 5 == 0 ? 1.0f : 0.0f);
    };
    for (std::uint32_t j = in.below(4); j > 0; --j) {
      fb_joint& joint = joints.emplace_back(fb_joint{sizeof(fb_joint), in.below(4), text(in), {}, {}});
      if (joint.parent == 3) joint.parent = FB_NO_JOINT;
      read_frame(joint.rest);
      if (in.below(2) > 0) read_frame(joint.inverse_bind);
      frames.resize(frames.size() + FB_FRAME_FLOATS);
      read_frame(&frames[frames.size() - FB_FRAME_FLOATS]);
    }
    rig.skin_influences = in.below(4);
    for (std::size_t i = 0; i < rig.vertex_count * rig.skin_influences; ++i) {
      skin_joints.push_back(static_cast<std::uint16_t>(in.below(4)));
      skin_weights.push_back(static_cast<float>(in.number<std::uint8_t>()) / 128);
    }
    for (std::size_t j = in.below(2) * joints.size(); j > 0; --j) joint_numbers.push_back(in.number<std::uint16_t>());
    rig.joint_stride = sizeof(fb_joint);
    rig.joint_count = static_cast<std::uint32_t>(joints.size());
    rig.joints = joints.data();
    rig.skin_joints = skin_joints.data();
    rig.skin_weights = skin_weights.data();
    rig.joint_numbers = joint_numbers.empty() ? nullptr : joint_numbers.data();
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  Input in(data, size);
  ForgedRig forged;
  forged.read_header(in);
  forged.read_controls(in);
  forged.read_mesh(in);
  forged.read_clips(in);
  forged.read_joints(in);
  forged.rig.user = &forged;
  forged.rig.evaluate = forged.oddities & 128 ? nullptr : &ForgedRig::evaluate;
  forged.rig.evaluate_skinned = forged.oddities & 128 ? nullptr : &ForgedRig::evaluate_skinned;
  try {
    fb::bake::RigSource source(forged.rig);
    std::vector<float> pose(source.schema().control_count()), points(source.rest().points.size());
    for (std::size_t c = 0; c < pose.size(); ++c) pose[c] = source.schema().controls[c].maximum;
    source.evaluate(pose, 1, points);
    for (std::size_t clip = 0; clip < source.clips().size(); ++clip) source.read(clip, 0, 1, points);
  } catch (const fb::Error& error) {
    if (std::strlen(error.what()) < 10) __builtin_trap();
  }
  return 0;
}

#include <map>

#include "production/draw.h"
#include "production/face_poses.h"

namespace rigs::production {
namespace {

// Whether a control goes to its maximum, the likelier the further that is from rest.
bool draw_way(const ControlRange& control, Draw& draw) {
  return draw.unit() * (control.maximum - control.minimum) < control.maximum;
}

class PoseRecorder {
 public:
  explicit PoseRecorder(const ControlList& controls) : list_(controls.list()) {
    for (std::size_t c = 0; c < list_.size(); ++c) {
      groups_[list_[c].group].push_back(c);
      std::string other = list_[c].name;
      const std::size_t at = std::min(other.find("_L"), other.find("_R"));
      if (at != std::string::npos) other[at + 1] = other[at + 1] == 'L' ? 'R' : 'L';
      partners_.push_back(c);
      for (std::size_t p = 0; p < list_.size(); ++p)
        if (list_[p].name == other) partners_[c] = p;
    }
  }

  std::vector<float> single(Draw& draw) const {
    std::vector<float> pose(list_.size());
    const std::size_t c = draw.below(list_.size());
    const float far = draw.unit() < 0.5f ? 1 : 0.5f;
    set(pose, c, draw_way(list_[c], draw), far);
    return pose;
  }

  // `count` controls of the whole face, each drawn a little or, one in fifteen, all the way.
  std::vector<float> scattered(std::size_t count, float most, Draw& draw) const {
    std::vector<float> pose(list_.size());
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t c = draw.below(list_.size());
      const float u = draw.unit(), far = draw.unit() < 0.066f ? 1 : most;
      set(pose, c, draw_way(list_[c], draw), far * u * std::sqrt(u));
    }
    return pose;
  }

  std::vector<float> expression(Draw& draw) const {
    std::vector<float> pose(list_.size());
    const std::size_t groups = 1 + draw.below(3);
    for (std::size_t g = 0; g < groups; ++g) {
      const auto group = std::next(groups_.begin(), static_cast<std::ptrdiff_t>(draw.below(groups_.size())));
      const std::vector<std::size_t>& members = group->second;
      const std::size_t count = 1 + static_cast<std::size_t>(0.5f * draw.unit() * static_cast<float>(members.size()));
      const float strength = draw.between(0.2f, 1.0f);
      const bool both = draw.unit() < 0.7f;
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t c = members[draw.below(members.size())];
        const bool up = draw_way(list_[c], draw);
        const float far = strength * draw.unit();
        set(pose, c, up, far);
        if (both) set(pose, partners_[c], up, far * draw.between(0.7f, 1.0f));
      }
    }
    return pose;
  }

  std::vector<float> of_several(Draw& draw) const {
    const float kind = draw.unit();
    if (kind < 0.41f) return scattered(4 + draw.below(21), 0.9f, draw);
    if (kind < 0.76f) return expression(draw);
    return scattered(40 + draw.below(80), 0.45f, draw);
  }

 private:
  void set(std::vector<float>& pose, std::size_t c, bool up, float fraction) const {
    pose[c] = (up ? list_[c].maximum : list_[c].minimum) * fraction;
  }

  const std::vector<ControlRange>& list_;
  std::map<std::string, std::vector<std::size_t>> groups_;
  std::vector<std::size_t> partners_;  // of each control on the other side, or itself
};

std::vector<float> record(const ControlList& controls, std::uint64_t seed, std::size_t count, float singles) {
  const PoseRecorder recorder(controls);
  std::vector<float> all;
  for (std::size_t i = 0; i < count; ++i) {
    Draw draw(seed, i);
    const std::vector<float> pose = draw.unit() < singles ? recorder.single(draw) : recorder.of_several(draw);
    all.insert(all.end(), pose.begin(), pose.end());
  }
  return all;
}

}  // namespace

std::vector<float> recorded_poses(const ControlList& controls, std::uint64_t seed, std::size_t count) {
  return record(controls, seed, count, 0.15f);
}

std::vector<float> random_poses(const ControlList& controls, std::uint64_t seed, std::size_t count) {
  return record(controls, seed, count, 0);
}

}  // namespace rigs::production

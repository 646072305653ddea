#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "export/character_view.h"
#include "export/driven_motion.h"
#include "export/glb_file.h"

namespace fb::tool {

// The joints of a face's host and its driven joints as one skeleton, with one skin, as glTF has it. A vertex that
// follows the host's joints h with weights u and driven joints j with weights w goes to the sum over h and j of
// u * w * (what h does) * (what j does), with what does not move as one of the j. So those driven joints stand below
// each h, and the vertex follows each of these with u * w. Meshes that the host does not move hang on a joint "root"
// that stays.
class DrivenSkeleton {
 public:
  // Fails with limit where these are more joints than a skin numbers. Both must outlive this.
  DrivenSkeleton(const CharacterView& character, const DrivenMotion& motion);
  DrivenSkeleton(const DrivenSkeleton&) = delete;
  DrivenSkeleton& operator=(const DrivenSkeleton&) = delete;

  // The character with that skeleton and that skin in place of the host's.
  const CharacterView& character() const { return made_; }
  // The motion of its joints.
  std::vector<JointTrack> tracks() const;

 private:
  // Where driven joints hang.
  struct Carrier {
    std::vector<bool> needed;           // driven joints that vertices of it follow, and those above them
    double weight = 0;                  // of these, summed
    std::uint32_t still = 0;            // the joint of what no driven joint moves
    std::vector<std::uint32_t> joints;  // of the needed ones
  };
  struct Influence {
    std::uint32_t joint;
    double weight;
  };

  std::vector<Influence> of_host(std::size_t vertex, bool follows) const;
  std::vector<Influence> driven(std::size_t vertex) const;
  void find_carriers();
  void add_joints(std::uint32_t host, Carrier& carrier);
  std::uint32_t add_joint(const std::string& name, std::uint32_t parent, const Frame& rest, const Frame& inverse_bind);
  void set_weights();

  const CharacterView& character_;
  const DrivenMotion& motion_;
  CharacterView made_;
  std::map<std::uint32_t, Carrier> carriers_;  // by joint of the host; FB_NO_JOINT: none
  std::set<std::string> taken_;
  std::deque<std::string> names_;  // of the joints that are added
  std::vector<std::uint16_t> skin_joints_;
  std::vector<float> skin_weights_;
};

}  // namespace fb::tool

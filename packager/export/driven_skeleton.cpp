#include "export/driven_skeleton.h"

#include <algorithm>

#include "base/status.h"

namespace fb::tool {
namespace {

// Calls `body` with each vertex of each mesh, and whether the mesh has vertices that follow driven joints.
template <typename Body>
void for_vertices(const CharacterView& character, const Body& body) {
  for (const fb_mesh& mesh : character.meshes) {
    const std::size_t first = mesh.first_vertex, count = mesh.vertex_count;
    const auto weights =
        character.driven_skin_weights.subspan(first * character.driven_influences, count * character.driven_influences);
    const bool follows = std::ranges::any_of(weights, [](float weight) { return weight > 0; });
    for (std::size_t v = first; v < first + count; ++v) body(v, follows);
  }
}

}  // namespace

DrivenSkeleton::DrivenSkeleton(const CharacterView& character, const DrivenMotion& motion)
    : character_(character), motion_(motion), made_(character) {
  for (const fb_joint& joint : character.joints) taken_.insert(joint.name);
  find_carriers();
  for (auto& [host, carrier] : carriers_) add_joints(host, carrier);
  constexpr std::size_t most = 65'536;
  if (made_.joints.size() > most)
    fail(Status::limit,
         "driven joints below each joint of the skeleton make %zu, more than the %zu of a skin: give --driven-joints "
         "none",
         made_.joints.size(), most);
  set_weights();
}

// What moves a vertex outside of driven joints. follows: whether its mesh follows any.
std::vector<DrivenSkeleton::Influence> DrivenSkeleton::of_host(std::size_t vertex, bool follows) const {
  std::vector<Influence> found;
  const std::size_t influences = character_.influences;
  for (std::size_t k = influences * vertex; k < influences * (vertex + 1); ++k)
    if (character_.skin_weights[k] > 0)
      found.push_back({character_.skin_joints[k], double(character_.skin_weights[k])});
  if (found.empty() && follows) found.push_back({FB_NO_JOINT, 1});
  return found;
}

std::vector<DrivenSkeleton::Influence> DrivenSkeleton::driven(std::size_t vertex) const {
  std::vector<Influence> found;
  const std::size_t influences = character_.driven_influences;
  for (std::size_t k = influences * vertex; k < influences * (vertex + 1); ++k)
    if (character_.driven_skin_weights[k] > 0)
      found.push_back({character_.driven_skin_joints[k], double(character_.driven_skin_weights[k])});
  return found;
}

void DrivenSkeleton::find_carriers() {
  const std::size_t count = character_.driven_joints.size();
  const auto carrier_of = [&](std::uint32_t host) -> Carrier& {
    Carrier& carrier = carriers_[host];
    carrier.needed.resize(count);
    return carrier;
  };
  for_vertices(character_, [&](std::size_t v, bool follows) {
    const std::vector<Influence> moved = driven(v);
    for (const Influence& host : of_host(v, follows)) {
      if (moved.empty() && host.joint != FB_NO_JOINT) continue;
      Carrier& carrier = carrier_of(host.joint);
      for (const Influence& one : moved) {
        carrier.needed[one.joint] = true;
        carrier.weight += host.weight * one.weight;
      }
    }
  });
  if (carriers_.empty()) carrier_of(FB_NO_JOINT);
  for (auto& [host, carrier] : carriers_)
    for (std::size_t j = count; j-- > 0;)  // joints come after their parents
      if (const std::uint32_t parent = character_.driven_joints[j].parent; carrier.needed[j] && parent != FB_NO_JOINT)
        carrier.needed[parent] = true;
  // All of them are somewhere, for what else hangs on them.
  const auto heaviest = std::ranges::max_element(
      carriers_, [](const auto& a, const auto& b) { return a.second.weight < b.second.weight; });
  heaviest->second.needed.assign(count, true);
}

std::uint32_t DrivenSkeleton::add_joint(const std::string& name, std::uint32_t parent, const Frame& rest,
                                        const Frame& inverse_bind) {
  std::string unique = name;
  for (std::size_t n = 2; !taken_.insert(unique).second; ++n) unique = format("%s (%zu)", name.c_str(), n);
  fb_joint joint;
  fb_joint_init(&joint);
  joint.name = names_.emplace_back(unique).c_str();
  joint.parent = parent;
  std::ranges::copy(to_floats(rest), joint.rest);
  std::ranges::copy(to_floats(inverse_bind), joint.inverse_bind);
  made_.joints.push_back(joint);
  return static_cast<std::uint32_t>(made_.joints.size()) - 1;
}

void DrivenSkeleton::add_joints(std::uint32_t host, Carrier& carrier) {
  // In the space of positions, which the host's joint has its inverse bind matrix from.
  std::uint32_t below;
  if (host == FB_NO_JOINT) {
    carrier.still = below = add_joint("root", FB_NO_JOINT, identity_place, identity_place);
  } else {
    carrier.still = host;
    const fb_joint& joint = character_.joints[host];
    below = add_joint(std::string(joint.name) + " driven", host, to_frame(joint.inverse_bind), identity_place);
  }
  for (std::size_t j = 0; j < carrier.needed.size(); ++j) {
    carrier.joints.push_back(FB_NO_JOINT);
    if (!carrier.needed[j]) continue;
    const fb_driven_joint& joint = character_.driven_joints[j];
    const std::uint32_t parent = joint.parent == FB_NO_JOINT ? below : carrier.joints[joint.parent];
    carrier.joints[j] = add_joint(joint.name, parent, motion_.rest()[j].frame(), motion_.inverse_binds()[j]);
  }
}

void DrivenSkeleton::set_weights() {
  std::vector<std::vector<Influence>> all;
  std::size_t most = 0;
  for_vertices(character_, [&](std::size_t v, bool follows) {
    std::vector<Influence>& found = all.emplace_back();
    const std::vector<Influence> moved = driven(v);
    double still = 1;
    for (const Influence& one : moved) still -= one.weight;
    for (const Influence& host : of_host(v, follows)) {
      if (moved.empty() && host.joint != FB_NO_JOINT) {
        found.push_back(host);
        continue;
      }
      const Carrier& carrier = carriers_.at(host.joint);
      if (still > 0) found.push_back({carrier.still, host.weight * still});
      for (const Influence& one : moved) found.push_back({carrier.joints[one.joint], host.weight * one.weight});
    }
    // Programs that take four take those that move it most.
    std::ranges::stable_sort(found, [](const Influence& a, const Influence& b) { return a.weight > b.weight; });
    most = std::max(most, found.size());
  });
  for (const std::vector<Influence>& found : all)
    for (std::size_t k = 0; k < most; ++k) {
      const bool used = k < found.size();
      skin_joints_.push_back(static_cast<std::uint16_t>(used ? found[k].joint : 0));
      skin_weights_.push_back(used ? static_cast<float>(found[k].weight) : 0.0f);
    }
  made_.influences = static_cast<std::uint32_t>(most);
  made_.skin_joints = skin_joints_;
  made_.skin_weights = skin_weights_;
}

std::vector<JointTrack> DrivenSkeleton::tracks() const {
  std::vector<JointTrack> tracks;
  for (std::size_t j = 0; j < motion_.tracks().size(); ++j) {
    if (motion_.tracks()[j].empty()) continue;
    JointTrack& track = tracks.emplace_back(JointTrack{{}, motion_.tracks()[j]});
    for (const auto& [host, carrier] : carriers_)
      if (carrier.needed[j]) track.joints.push_back(carrier.joints[j]);
  }
  return tracks;
}

}  // namespace fb::tool

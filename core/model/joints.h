// The skeleton that carries a face, and how vertices follow it. Positions of a model are before skinning: a host poses
// the face first and skins it then.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace fb {

struct Mesh;

inline constexpr std::uint32_t no_joint = 0xffffffff;
inline constexpr std::uint32_t most_influences = 32;
inline constexpr std::size_t most_joints = 65536;

// The upper three rows of a 4 x 4 matrix, row after row.
template <class Number>
using Frame = std::array<Number, 12>;

struct Joint {
  std::string name;                 // unique, not empty
  std::uint32_t parent = no_joint;  // index of a joint before it
  Frame<float> rest = {};           // at rest, in its parent
  Frame<float> inverse_bind = {};   // from the space of positions to the joint's
  bool operator==(const Joint&) const = default;
};

// What each vertex of the surface follows. Weights of a vertex sum to 1, or all vertices of its mesh have weights of 0.
// Weights of 0 come last.
struct Skin {
  std::uint32_t influences = 0;       // of each vertex; 0: no skin
  std::vector<std::uint16_t> joints;  // vertices x influences
  std::vector<float> weights;         // of each
  bool operator==(const Skin&) const = default;

  // Those of a vertex that are not 0.
  std::size_t count(std::size_t vertex) const;
};

// The identity: of what has not moved.
inline constexpr Frame<double> still_frame = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

Frame<double> product(const Frame<double>& a, const Frame<double>& b);
// Nothing where it cannot be inverted in floating point.
std::optional<Frame<double>> inverse(const Frame<double>& frame);
Frame<double> to_double(const Frame<float>& frame);
Frame<float> to_float(const Frame<double>& frame);

// Where joints are at rest.
std::vector<Frame<double>> rest_frames(std::span<const Joint> joints);

// Gives joints whose inverse bind matrix is all 0 the inverse of where they are at rest. Fails where there is none.
void set_default_inverse_bind(std::vector<Joint>& joints);

// Adds up the weights of a joint that a vertex names several times, puts weights of 0 last, and takes away influences
// that no vertex has. A skin without any is none.
void tidy(Skin& skin);

// Fails, naming joint or vertex, on a name that is empty or occurs twice, a parent that is not before its joint, what
// is not finite, influences of joints that there are not, weights that do not sum to 1, and vertices without joints in
// a mesh where others have some. `partly`: weights of a vertex may sum to less, down to 0; what is missing stays.
// `rest`: the mesh, which has been checked.
void check(std::span<const Joint> joints, const Skin& skin, const Mesh& rest, bool partly = false);

}  // namespace fb

// The rest mesh of the sample face: one mesh of quads, several components, with the loops the deformers need.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "vec3.h"

namespace sample_face {

using Index = std::uint32_t;
using Ring = std::vector<Index>;  // a closed loop, counter-clockwise seen from outside

struct Span {
  Index first = 0, count = 0;
};

inline constexpr int kMouthColumns = 44;
inline constexpr int kLidColumns = 32;

// Rings of the lips from the skin around the mouth inwards. All rings have kMouthColumns vertices; column i of one ring
// continues column i of the next.
enum MouthRing : int {
  kMouthOuter = 0,  // where the loops leave the grid of the skin; two free loops follow
  kLipBorder = 3,   // of the vermilion
  kLipRise,
  kLipMiddle,
  kLipFront,
  kLipSeam,  // where the lips meet
  kLipInner,
  kLipBack,
  kBagFirst,  // the inside of the mouth
  kMouthRings = kBagFirst + 5
};

// Rings of an eye's lids from the skin around the eye inwards, kLidColumns vertices each.
enum LidRing : int {
  kLidOuter = 0,   // where the loops leave the grid of the skin; two free loops follow
  kLidCrease = 3,  // the fold over the lid
  kLidPlate,
  kLidEdge,
  kLidMargin,  // front edge of the opening
  kLidBack,    // back edge
  kLidInner,   // tucked between lid and eyeball
  kLidRings
};

struct FaceMesh {
  std::vector<Vec3> points;
  std::vector<std::array<Index, 4>> quads;
  std::array<Ring, kMouthRings> mouth;
  std::array<std::array<Ring, kLidRings>, 2> lids;  // left (+x), right
  Span skin;                                        // includes lips, inside of the mouth, lids and ears
  std::array<Span, 2> eyes;                         // left, right
  Span upper_teeth, lower_teeth, tongue;
  // What texture coordinates are laid out by.
  Ring neck;                                     // the lower edge of the skin, from the middle of the face
  Ring seam;                                     // up the back of the head, from the neck to the middle of the crown
  Ring throat;                                   // all vertices that close the inside of the mouth
  std::array<std::vector<Ring>, 2> eye_rings;    // from the pupil back
  std::array<std::vector<Ring>, 2> teeth_rings;  // upper, lower: sections from the right end of the row to the left
  std::vector<Ring> tongue_rings;                // from the tip back

  Index add(Vec3 p);
  // Quads between two rings of equal size, `inner` lying inside `outer` (or above it).
  void bridge(const Ring& outer, const Ring& inner);
  // Closes a ring of 2 (a + b) vertices with a x b quads; the ring starts at a corner and runs along side a first.
  // Returns all of their vertices, rows of a + 1.
  Ring cap(const Ring& ring, int a, int b);
};

// Parameters of a column of the mouth: where it meets the lips.
struct MouthColumn {
  float across = 0;  // -1 at the right corner, 1 at the left
  float side = 0;    // 1 upper lip, -1 lower lip, 0 corners
};
MouthColumn mouth_column(int column);

// The other lip's column opposite to this one; corners are their own.
int opposite_column(int column);

// Where a column of the lids meets the opening: its angle round the opening, 0 at the outer corner, pi/2 at the top.
// The same for both eyes when seen from outside.
float lid_angle(int eye, int column);

// Builds everything. Deterministic; takes some tenths of a second.
FaceMesh build_face_mesh();

// The parts, in the order they are added.
void add_head(FaceMesh& mesh);          // skin with all its loops
void add_eye(FaceMesh& mesh, int eye);  // 0 left, 1 right
void add_teeth(FaceMesh& mesh, bool upper);
void add_tongue(FaceMesh& mesh);

// Loops of the skin, given their outermost ring: they add the inner rings and fill mesh.mouth or mesh.lids.
void add_mouth_loops(FaceMesh& mesh, const Ring& outer);
void add_lid_loops(FaceMesh& mesh, const Ring& outer, int eye);
// These two place `outer` as well; the inner vertices end up hanging on it.
void add_ear_loops(FaceMesh& mesh, const Ring& outer, int a, int b, int side);
void add_nostril_loops(FaceMesh& mesh, const Ring& outer, int a, int b, int side);

}  // namespace sample_face

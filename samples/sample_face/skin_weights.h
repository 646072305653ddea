// How strongly parts of the mesh follow the jaw, the lids and the lips.
#pragma once

#include <array>
#include <vector>

#include "face_mesh.h"

namespace sample_face {

// How much of the lids' sliding each ring takes part in, LidRing by LidRing.
inline constexpr std::array<float, kLidRings> kLidFollow = {0.0f, 0.04f, 0.14f, 0.36f, 0.72f, 0.95f, 1.0f, 1.0f, 0.6f};

// How much of the lips' meeting each ring takes part in, MouthRing by MouthRing. The rings that meet take all of it.
inline constexpr std::array<float, kMouthRings> kLipFollow = {0.0f, 0.08f, 0.24f, 0.5f, 0.78f, 0.97f, 1.0f, 1.0f,
                                                              1.0f, 0.7f,  0.3f,  0.1f, 0.0f,  0.0f,  0.0f};

// Weight of the jaw on each vertex: diffused over the skin's own edges from the chin and the lower lip (1) and the
// upper face (0), so that it jumps across the mouth's line and nowhere else. Teeth and tongue are included.
std::vector<float> jaw_weights(const FaceMesh& mesh);

}  // namespace sample_face

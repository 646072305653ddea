// What the surface of the face looks like: its materials, and the one picture that colours them all.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "face_mesh.h"

namespace sample_face {

struct FaceMaterial {
  const char* name;
  std::array<float, 3> colour;  // linear; the picture is of what is left, so that programs without pictures show it
  float roughness;
};

inline constexpr int kFaceMaterials = 4;

// Skin with lips and inside of the mouth, eyes, teeth with gums, tongue: the order in which the mesh has them.
const std::array<FaceMaterial, kFaceMaterials>& face_materials();

// Quads of each material, one after the other.
std::array<std::uint32_t, kFaceMaterials> material_quads(const FaceMesh& mesh);

// face_colour.png, as paint_colours.py draws it: base colours, in the layout of uv_layout.h.
std::span<const unsigned char> face_colour();

}  // namespace sample_face

#include "face_materials.h"

namespace sample_face {

const std::array<FaceMaterial, kFaceMaterials>& face_materials() {
  static constexpr std::array<FaceMaterial, kFaceMaterials> materials = {{{"skin", {0.871f, 0.565f, 0.423f}, 0.55f},
                                                                          {"eye", {0.855f, 0.823f, 0.775f}, 0.12f},
                                                                          {"teeth", {0.840f, 0.783f, 0.672f}, 0.25f},
                                                                          {"tongue", {0.604f, 0.138f, 0.133f}, 0.4f}}};
  return materials;
}

std::array<std::uint32_t, kFaceMaterials> material_quads(const FaceMesh& mesh) {
  // The first vertex of each that comes after the skin.
  const std::array<Index, kFaceMaterials - 1> first = {mesh.eyes[0].first, mesh.upper_teeth.first, mesh.tongue.first};
  std::array<std::uint32_t, kFaceMaterials> counts{};
  for (const auto& quad : mesh.quads) {
    std::size_t material = 0;
    for (const Index begin : first) material += quad[0] >= begin;
    ++counts[material];
  }
  return counts;
}

}  // namespace sample_face

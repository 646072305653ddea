#include "bake/measure/face_parts.h"

#include <map>
#include <set>

#include "bake/measure/measured_face.h"
#include "base/checked.h"

namespace fb::bake {
namespace {

std::vector<double> mean_squares(const PackedModel& model, std::span<const float> poses) {
  MeasuredFace face(model);
  std::vector<double> squares(face.evaluator().coefficient_count());
  for (std::size_t at = 0; at < poses.size(); at += model.schema.control_count()) {
    const std::span<const float> coefficients = face.coefficients(&poses[at]);
    for (std::size_t c = 0; c < squares.size(); ++c) squares[c] += double(coefficients[c]) * coefficients[c];
  }
  return squares;
}

}  // namespace

FaceParts face_parts(const PackedModel& model, std::span<const float> poses) {
  const std::size_t vertices = model.rest.surface_vertex_count(), regions = model.regions.size();
  FaceParts parts{{}, std::vector<std::uint32_t>(vertices, checked_u32(regions, "regions"))};
  std::vector<std::size_t> region_of(model.direct.size(), regions);  // of a column
  for (const PackedRegion& region : model.regions) {
    region_of.resize(region_of.size() + region.layers.back().outputs, parts.names.size());
    parts.names.push_back(region.name);
  }
  const std::vector<double> squares = mean_squares(model, poses);
  std::vector<double> moved(vertices * regions);
  for (const PackedRowBlock& group : model.row_blocks)
    for (std::size_t c = 0; c < group.columns.size(); ++c) {
      const std::size_t column = group.columns[c].column;
      if (region_of[column] == regions || group.first_row >= 3 * vertices) continue;
      const std::vector<float> moves = displacements(group, c);
      for (std::uint32_t i = 0; i < group.row_count; ++i)
        moved[model.coordinate(group.first_row + i) / 3 * regions + region_of[column]] +=
            squares[column] * moves[i] * moves[i];
    }
  for (std::size_t v = 0; v < vertices; ++v) {
    double most = 0;
    for (std::uint32_t r = 0; r < regions; ++r)
      if (moved[v * regions + r] > most) {
        most = moved[v * regions + r];
        parts.labels[v] = r;
      }
  }
  return parts;
}

void describe(FaceParts& parts, const FaceMap& map, const RigSchema& schema) {
  constexpr std::size_t most_movers = 5;
  std::vector<std::vector<std::uint32_t>> vertices(parts.names.size());
  for (std::uint32_t v = 0; v < parts.labels.size(); ++v)
    if (parts.labels[v] < vertices.size()) vertices[parts.labels[v]].push_back(v);
  std::map<std::string, std::vector<std::uint32_t>> of_group;
  std::map<std::string, int> parts_of_group;
  for (const std::vector<std::uint32_t>& part : vertices) {
    const std::string group = map.group_of(part);
    of_group[group].insert(of_group[group].end(), part.begin(), part.end());
    parts_of_group[group] += !part.empty();
  }
  std::set<std::string> taken;
  for (const std::vector<std::uint32_t>& part : vertices) {
    std::string& title = parts.titles.emplace_back();
    std::vector<std::string>& movers = parts.movers.emplace_back();
    if (part.empty()) continue;
    const std::string group = map.group_of(part);
    const bool only = group.empty() || parts_of_group[group] == 1;
    const std::string place = map.place_in(only ? map.moving_part() : map.box_of(of_group[group]), part);
    const std::string name = group.empty() ? place : group + ", " + place;
    title = name;
    for (int number = 2; !taken.insert(title).second; ++number) title = name + " " + std::to_string(number);
    for (const std::uint32_t c : map.movers(part, most_movers)) movers.push_back(schema.controls[c].name);
  }
}

}  // namespace fb::bake

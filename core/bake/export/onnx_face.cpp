#include "bake/export/onnx_face.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bake/export/onnx_basis.h"
#include "bake/export/onnx_driven_joints.h"
#include "bake/export/onnx_graph.h"
#include "bake/export/onnx_layers.h"
#include "base/checked.h"
#include "base/status.h"

namespace fb::bake {
namespace {

const OnnxAttribute along_columns{"axis", {1}};

// One number of every control, as a tensor that is broadcast over a batch.
template <class Get>
std::string of_controls(OnnxGraph& graph, const char* label, const RigSchema& schema, Get&& get) {
  std::vector<float> values;
  for (const Control& control : schema.controls) values.push_back(get(control));
  return graph.floats(label, values, {1, static_cast<std::int64_t>(values.size())});
}

// The controls within their ranges.
std::string clamped_controls(OnnxGraph& graph, const RigSchema& schema) {
  const std::string low = of_controls(graph, "minimum", schema, [](const Control&c) { return c.minimum; }),
                    high = of_controls(graph, "maximum", schema, [](const Control&c) { return c.maximum; });
  return graph.node("Min", "clamped", {graph.node("Max", "clamped", {"controls", low}), high});
}

// The values of all features of a face: of controls kind by kind, then of combinations of those that are there.
class FeatureGraph {
 public:
  FeatureGraph(OnnxGraph& graph, const PackedModel& model, const std::string& offsets)
      : graph_(graph), model_(model), offsets_(offsets), places_(model.features.size(), none) {
    for (const FeatureKind kind : {FeatureKind::identity, FeatureKind::ramp, FeatureKind::hat}) add_kind(kind);
    while (placed_ < model.features.size()) add_combinations();
  }

  // These features, as columns.
  std::string gather(const std::string& label, std::span<const std::uint32_t> features) {
    std::vector<std::uint32_t> places;
    for (const std::uint32_t feature : features) places.push_back(places_[feature]);
    return graph_.node("Gather", label, {values_, graph_.indices(label, places)}, {along_columns});
  }

 private:
  static constexpr std::uint32_t none = UINT32_MAX;

  // Appends columns: the values of these features.
  void append(const std::string& columns, const std::vector<std::uint32_t>& features) {
    for (const std::uint32_t feature : features) places_[feature] = placed_++;
    values_ = values_.empty() ? columns : graph_.node("Concat", "features", {values_, columns}, {along_columns});
  }

  std::string row(const char* label, const std::vector<std::uint32_t>& features, float Feature::*number) {
    std::vector<float> numbers;
    for (const std::uint32_t f : features) numbers.push_back(model_.features[f].*number);
    return graph_.floats(label, numbers, {1, static_cast<std::int64_t>(numbers.size())});
  }

  void add_kind(FeatureKind kind) {
    std::vector<std::uint32_t> features, controls;
    for (std::uint32_t f = 0; f < model_.features.size(); ++f) {
      if (model_.features[f].kind != kind) continue;
      features.push_back(f);
      controls.push_back(model_.features[f].control);
    }
    if (features.empty()) return;
    std::string u =
        graph_.node("Gather", "offsets", {offsets_, graph_.indices("controls_of", controls)}, {along_columns});
    u = graph_.node("Mul", "scaled", {u, row("scale", features, &Feature::scale)});
    if (kind == FeatureKind::identity) return append(u, features);
    std::string t = graph_.node("Sub", "beyond", {u, row("threshold", features, &Feature::threshold)});
    if (kind == FeatureKind::hat) {
      const std::string one = graph_.number("one", 1);
      const std::string left = graph_.node("Sub", "left", {one, t});
      const std::string fallen = graph_.node("Mul", "fallen", {left, row("fall", features, &Feature::fall)});
      t = graph_.node("Min", "hat", {t, graph_.node("Add", "falling", {one, fallen})});
    }
    append(graph_.node("Relu", "feature", {t}), features);
  }

  // All products, then all minimums, of features that are there.
  void add_combinations() {
    const std::uint32_t before = placed_;
    for (const FeatureKind kind : {FeatureKind::product, FeatureKind::minimum}) {
      std::vector<std::uint32_t> features, first, second;
      const std::vector<std::uint32_t> there = places_;
      for (std::uint32_t f = 0; f < model_.features.size(); ++f) {
        const Feature& feature = model_.features[f];
        if (feature.kind != kind || there[f] != none || there[feature.first] == none || there[feature.second] == none)
          continue;
        features.push_back(f);
        first.push_back(feature.first);
        second.push_back(feature.second);
      }
      if (features.empty()) continue;
      const std::string a = gather("first", first), b = gather("second", second);
      append(graph_.node(kind == FeatureKind::product ? "Mul" : "Min", "combined", {a, b}), features);
    }
    if (placed_ == before) fail(Status::internal, "features that depend on each other in a circle");
  }

  OnnxGraph& graph_;
  const PackedModel& model_;
  std::string offsets_, values_;
  std::vector<std::uint32_t> places_;  // column of each feature
  std::uint32_t placed_ = 0;
};

// How far the gate of a region is open, a column.
std::string add_gate(OnnxGraph& graph, const std::string& label, const Gate& gate, FeatureGraph& features) {
  const std::string sizes = graph.node("Abs", label, {features.gather(label, gate.features)});
  const std::string sum = graph.sum_in_order(label, sizes, 1, gate.features.size()),
                    largest = graph.node("ReduceMax", label, {sizes}, {{"axes", {1}, true}});
  const std::string slope = graph.number(label, gate.slope);
  const std::string value = graph.node("Mul", label, {graph.node("Sub", label, {sum, largest}), slope});
  return graph.node("Clip", label, {value, graph.number(label, 0), graph.number(label, 1)});
}

std::string add_region(OnnxGraph& graph, const PackedRegion& region, FeatureGraph& features, OnnxFace& size) {
  const std::string label = "region/" + region.name;
  const std::string y = add_layers(graph, region, features.gather(label, region.features), size.parameters);
  if (region.gate.features.empty()) return y;
  return graph.node("Mul", label, {y, add_gate(graph, label + "/gate", region.gate, features)});
}

// Weights of the exact poses, a column each; a sum of more than 1 is scaled to 1.
std::string exact_weights(OnnxGraph& graph, const PackedModel& model, const std::string& clamped) {
  const auto count = static_cast<std::int64_t>(model.exact.size()),
             width = static_cast<std::int64_t>(model.schema.control_count());
  const std::string low = of_controls(graph, "minimum", model.schema, [](const Control&c) { return c.minimum; }),
                    length = of_controls(graph, "length", model.schema,
                                         [](const Control&c) { return c.maximum - c.minimum; });
  std::vector<float> exact_places, falloffs;
  for (const ExactPose& pose : model.exact) {
    const std::vector<float> places = places_in_ranges(model.schema, pose.controls);
    exact_places.insert(exact_places.end(), places.begin(), places.end());
    falloffs.push_back(pose.falloff);
  }
  std::string places = graph.node("Div", "places", {graph.node("Sub", "places", {clamped, low}), length});
  const std::int64_t second[] = {1}, row[] = {0, count};
  places = graph.node("Unsqueeze", "places", {places, graph.integers("axes", second)});
  const std::string apart =
      graph.node("Sub", "apart", {places, graph.floats("exact/places", exact_places, {1, count, width})});
  const std::string squares =
      graph.sum_in_order("distance", graph.node("Mul", "square", {apart, apart}), 2, model.schema.control_count());
  const std::string distance = graph.node("Reshape", "distance", {squares, graph.integers("shape", row)});
  const std::string far = graph.node("Mul", "far", {distance, graph.floats("falloff", falloffs, {1, count})});
  const std::string near = graph.node("Relu", "near", {graph.node("Sub", "near", {graph.number("one", 1), far})});
  const std::string weights = graph.node("Mul", "exact/weights", {near, near});
  const std::string sum = graph.sum_in_order("exact/sum", weights, 1, model.exact.size());
  return graph.node("Div", "exact/weights", {weights, graph.node("Max", "exact/sum", {sum, graph.number("one", 1)})});
}

// Positions and channels of all rows, in the order of rest.points.
std::string all_positions(OnnxGraph& graph, const PackedModel& model, OnnxFace& size) {
  const std::string clamped = clamped_controls(graph, model.schema);
  const std::string offsets = graph.node(
      "Sub", "offsets", {clamped, of_controls(graph, "rest", model.schema, [](const Control& c) { return c.rest; })});
  std::vector<std::string> coefficients;
  FeatureGraph features(graph, model, offsets);
  if (!model.direct.empty()) coefficients.push_back(features.gather("direct", model.direct));
  for (const PackedRegion& region : model.regions) coefficients.push_back(add_region(graph, region, features, size));
  if (coefficients.empty()) {  // a face that nothing moves
    const std::uint32_t first[] = {0};
    const std::string one = graph.node("Gather", "none", {offsets, graph.indices("none", first)}, {along_columns});
    coefficients.push_back(graph.node("Mul", "none", {one, graph.number("zero", 0)}));
  }
  std::string rows =
      add_basis(graph, model, graph.node("Concat", "coefficients", coefficients, {along_columns}), size.parameters);
  std::vector<std::uint32_t> row_of(model.rest.points.size());
  for (std::uint32_t row = 0; row < row_of.size(); ++row) row_of[model.coordinate(row)] = row;
  if (!std::ranges::is_sorted(row_of))
    rows = graph.node("Gather", "displacements", {rows, graph.indices("rows", row_of)}, {along_columns});
  const auto count = static_cast<std::int64_t>(row_of.size());
  const std::string points =
      graph.node("Add", "points", {rows, graph.floats("rest/points", model.rest.points, {1, count})});
  if (model.exact.empty()) return points;
  return add_corrections(graph, model, points, exact_weights(graph, model, clamped), size.parameters);
}

void add_channels(OnnxGraph& graph, const PackedModel& model, const std::string& all) {
  const std::vector<Channel>& channels = model.schema.channels;
  if (channels.empty()) return;
  const auto count = static_cast<std::int64_t>(channels.size());
  std::vector<std::uint32_t> columns(channels.size());
  std::iota(columns.begin(), columns.end(), checked_u32(3 * model.rest.surface_vertex_count(), "coordinates"));
  std::vector<float> rest, scale, low, high;
  for (const Channel& channel : channels) {
    rest.push_back(channel.rest);
    scale.push_back(channel.scale);
    low.push_back(channel.minimum);
    high.push_back(channel.maximum);
  }
  const auto row = [&](const char* label, const std::vector<float>& values) {
    return graph.floats(label, values, {1, count});
  };
  std::string x = graph.node("Gather", "channels", {all, graph.indices("channels", columns)}, {along_columns});
  x = graph.node("Mul", "channels", {x, row("channels/scale", scale)});
  x = graph.node("Add", "channels", {x, row("channels/rest", rest)});
  x = graph.node("Max", "channels", {x, row("channels/minimum", low)});
  graph.output("channels", graph.node("Min", "channels", {x, row("channels/maximum", high)}), {count});
}

std::vector<std::pair<std::string, std::string>> properties_of(const PackedModel& model, const OnnxTexts& texts) {
  using Json = nlohmann::ordered_json;
  Json controls = Json::array(), channels = Json::array(), joints = Json::array();
  for (const Control& c : model.schema.controls)
    controls.push_back({{"name", c.name}, {"min", c.minimum}, {"max", c.maximum}, {"default", c.rest}});
  for (const Channel& c : model.schema.channels) channels.push_back(c.name);
  for (const DrivenJoint& joint : model.rest.driven.joints) joints.push_back(joint.name);
  const auto text = [](const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); };
  std::vector<std::pair<std::string, std::string>> properties = {{"facebaker.controls", text(controls)},
                                                                 {"facebaker.units", model.schema.units},
                                                                 {"facebaker.up_axis", model.schema.up_axis}};
  if (!channels.empty()) properties.emplace_back("facebaker.channels", text(channels));
  if (!joints.empty()) properties.emplace_back("facebaker.joints", text(joints));
  if (!texts.licence.empty()) properties.emplace_back("facebaker.licence", texts.licence);
  if (!model.character.about.empty()) properties.emplace_back("facebaker.about", model.character.about);
  return properties;
}

}  // namespace

OnnxFace write_onnx(const std::filesystem::path& path, const PackedModel& model, const OnnxTexts& texts) {
  OnnxFace size;
  OnnxGraph graph;
  const auto controls = static_cast<std::int64_t>(model.schema.control_count()),
             vertices = static_cast<std::int64_t>(model.rest.surface_vertex_count());
  graph.input("controls", {controls});
  const std::string all = all_positions(graph, model, size);
  std::string surface = all;
  if (model.rest.carrier_vertices > 0) {
    const std::int64_t begin[] = {0}, end[] = {3 * vertices}, axis[] = {1};
    surface =
        graph.node("Slice", "surface",
                   {all, graph.integers("begin", begin), graph.integers("end", end), graph.integers("axis", axis)});
  }
  const auto shaped = [&](const std::string& positions, std::span<const std::int64_t> shape) {
    return graph.node("Reshape", "positions", {positions, graph.integers("shape", shape)});
  };
  const std::int64_t vectors[] = {0, vertices, 3};  // 0: as in the input
  const DrivenJoints& driven = model.rest.driven;
  if (!driven.empty()) {
    const std::int64_t columns[] = {0, vertices, 1, 3};
    const std::string changes = add_joint_changes(graph, model.rest, all);
    surface = add_driven_skin(graph, model.rest, shaped(surface, columns), changes, size.parameters);
    graph.output("joints", add_joint_frames(graph, driven, changes),
                 {static_cast<std::int64_t>(driven.joints.size()), 3, 4});
  }
  graph.output("positions", shaped(surface, vectors), {vertices, 3});
  add_channels(graph, model, all);
  size.nodes = graph.nodes();
  graph.write(path, model.schema.name, texts.producer_version, properties_of(model, texts));
  return size;
}

}  // namespace fb::bake

#include "archive/section_reader.h"

#include "archive/layout.h"

namespace fb {
namespace {

// rows x columns 16-bit numbers, row r times scales[r].
std::vector<float> read_scaled(ByteReader& in, const std::vector<float>& scales, std::uint64_t columns) {
  const std::uint64_t count = checked_multiply(scales.size(), columns, in.where().c_str());
  const auto low = in.take(count, "the low bytes of values");
  const auto high = in.take(count, "the high bytes of values");
  in.budget().take(count, sizeof(float), in.where().c_str());
  std::vector<float> values(count);
  std::size_t i = 0;
  for (const float scale : scales)
    for (std::uint64_t c = 0; c < columns; ++c, ++i) values[i] = float(from_planes16(low, high, i)) * scale;
  return values;
}

DenseLayer read_layer(ByteReader& in) {
  DenseLayer layer;
  layer.inputs = in.number<std::uint32_t>("a layer's width");
  layer.outputs = in.number<std::uint32_t>("a layer's width");
  layer.activation = static_cast<Activation>(in.number<std::uint32_t>("an activation"));
  const auto skip = in.number<std::uint32_t>("a skip flag");
  if (skip > 1) in.damaged("a skip flag is neither 0 nor 1");
  layer.skip = skip == 1;
  layer.bias = in.numbers<float>(layer.outputs, "biases");
  const auto scales = in.numbers<float>(layer.outputs, "weight scales");
  layer.weights = read_scaled(in, scales, layer.inputs);
  return layer;
}

}  // namespace

Definition read_definition(ByteReader& in) {
  Definition definition;
  RigSchema& schema = definition.schema;
  schema.name = in.string("the name");
  schema.units = in.string("the units");
  schema.up_axis = in.string("the up axis");
  definition.vertices = in.number<std::uint32_t>("the number of vertices");
  if (definition.vertices > max_vertices) in.damaged("more vertices than the format allows");
  const std::uint32_t controls = in.count(20, "controls");
  in.budget().take(controls, sizeof(Control), "controls");
  schema.controls.resize(controls);
  for (Control& control : schema.controls) {
    control.name = in.string("a control's name");
    control.group = in.string("a control's group");
    control.minimum = in.number<float>("a control's minimum");
    control.maximum = in.number<float>("a control's maximum");
    control.rest = in.number<float>("a control's default");
  }
  in.end();
  return definition;
}

void read_polygons(ByteReader& in, std::uint32_t vertices, Mesh& mesh) {
  const auto polygons = in.number<std::uint32_t>("the number of polygons");
  const auto corners = in.number<std::uint32_t>("the number of corners");
  mesh.polygon_sizes = in.planes32(polygons, "polygon sizes");
  std::uint64_t sum = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) sum += size;
  if (sum != corners) in.damaged("polygon sizes do not add up to the number of corners");
  mesh.polygon_corners = in.planes32(corners, "polygon corners");
  // Steps are in zigzag form; each is undone from corners already decoded in place.
  std::size_t at = 0;
  std::uint32_t previous_size = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    for (std::uint32_t k = 0; k < size; ++k, ++at) {
      const std::uint32_t before = corner_before(mesh.polygon_corners, at, k, previous_size);
      const std::uint32_t zigzag = mesh.polygon_corners[at];
      const std::uint32_t corner = before + ((zigzag >> 1) ^ (0u - (zigzag & 1)));
      if (corner >= vertices) in.damaged("a polygon names a vertex that does not exist");
      mesh.polygon_corners[at] = corner;
    }
    previous_size = size;
  }
  in.end();
}

Network read_network(ByteReader& in) {
  Network network;
  const std::uint32_t features = in.count(16, "features");
  in.budget().take(features, sizeof(Feature), "features");
  network.features.resize(features);
  for (Feature& feature : network.features) {
    feature.kind = static_cast<Feature::Kind>(in.number<std::uint32_t>("a feature's kind"));
    feature.control = in.number<std::uint32_t>("a feature's control");
    feature.scale = in.number<float>("a feature's scale");
    feature.threshold = in.number<float>("a feature's threshold");
  }
  network.direct = in.numbers<std::uint32_t>(in.count(4, "direct coefficients"), "direct coefficients");
  const std::uint32_t regions = in.count(12, "regions");
  in.budget().take(regions, sizeof(Region), "regions");
  network.regions.resize(regions);
  for (Region& region : network.regions) {
    region.name = in.string("a region's name");
    region.features = in.numbers<std::uint32_t>(in.count(4, "region features"), "region features");
    const std::uint32_t layers = in.count(16, "layers");
    in.budget().take(layers, sizeof(DenseLayer), "layers");
    region.layers.reserve(layers);
    for (std::uint32_t l = 0; l < layers; ++l) region.layers.push_back(read_layer(in));
  }
  in.end();
  return network;
}

Basis read_basis(ByteReader& in) {
  Basis basis;
  basis.rows = in.number<std::uint32_t>("the number of rows");
  basis.columns = in.number<std::uint32_t>("the number of columns");
  const std::uint32_t groups = in.count(8, "row groups");
  in.budget().take(groups, sizeof(RowGroup), "row groups");
  basis.groups.resize(groups);
  std::uint64_t row = 0, scales = 0, values = 0;
  for (RowGroup& group : basis.groups) {
    group.first_row = static_cast<std::uint32_t>(row);
    group.row_count = in.number<std::uint32_t>("a row group's rows");
    group.columns = in.numbers<std::uint32_t>(in.count(4, "a row group's columns"), "a row group's columns");
    row += group.row_count;
    if (row > basis.rows) in.damaged("row groups go beyond the last row");
    scales += group.columns.size();
    values += std::uint64_t(group.row_count) * group.columns.size();
  }
  const std::vector<float> all_scales = in.numbers<float>(scales, "scales");
  const auto low = in.take(values, "the low bytes of values");
  const auto high = in.take(values, "the high bytes of values");
  in.end();
  in.budget().take(values, sizeof(float), in.where().c_str());
  std::size_t value = 0, scale = 0;
  for (RowGroup& group : basis.groups) {
    group.values.resize(group.columns.size() * group.row_count);
    for (std::size_t i = 0; i < group.values.size(); ++value) {
      group.values[i] = float(from_planes16(low, high, value)) * all_scales[scale];
      if (++i % group.row_count == 0) ++scale;
    }
  }
  return basis;
}

Proof read_proof(ByteReader& in, std::size_t controls, std::uint32_t vertices) {
  Proof proof;
  const auto poses = in.number<std::uint32_t>("the number of poses");
  proof.vertices = in.numbers<std::uint32_t>(in.count(4, "proof vertices"), "proof vertices");
  for (const std::uint32_t vertex : proof.vertices)
    if (vertex >= vertices) in.damaged("the proof names a vertex that does not exist");
  proof.controls = in.numbers<float>(checked_multiply(poses, controls, "proof controls"), "proof controls");
  proof.positions =
      in.numbers<float>(checked_multiply(poses, checked_multiply(proof.vertices.size(), 3, "proof"), "proof positions"),
                        "proof positions");
  in.end();
  return proof;
}

}  // namespace fb

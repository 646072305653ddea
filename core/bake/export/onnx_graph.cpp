#include "bake/export/onnx_graph.h"

#include <bit>

#include "base/file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

static_assert(std::endian::native == std::endian::little, "raw_data of a tensor is little-endian");

constexpr std::int64_t ir_version = 7, operator_set = 13;
constexpr std::int64_t float32 = 1, int64 = 7;  // TensorProto.DataType
constexpr std::uint64_t largest_file = INT32_MAX;

template <class T>
ProtobufMessage onnx_tensor(const std::string& name, std::span<const T> values, const std::vector<std::int64_t>& shape,
                            std::int64_t type) {
  ProtobufMessage tensor;
  for (const std::int64_t size : shape) tensor.number(1, size);
  tensor.number(2, type);
  tensor.bytes(8, name);
  tensor.bytes(9, {reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  return tensor;
}

ProtobufMessage onnx_attribute(const OnnxAttribute& from) {
  constexpr std::int64_t one_number = 2, numbers = 7;  // AttributeProto.AttributeType
  ProtobufMessage attribute;
  attribute.bytes(1, from.name);
  for (const std::int64_t value : from.values) attribute.number(from.list ? 8 : 3, value);
  attribute.number(20, from.list ? numbers : one_number);
  return attribute;
}

ProtobufMessage onnx_value(const std::string& name, const std::vector<std::int64_t>& shape) {
  ProtobufMessage sizes, batch;
  batch.bytes(2, "n");
  sizes.message(1, batch);
  for (const std::int64_t size : shape) {
    ProtobufMessage one;
    one.number(1, size);
    sizes.message(1, one);
  }
  ProtobufMessage tensor_type, type, value;
  tensor_type.number(1, float32);
  tensor_type.message(2, sizes);
  type.message(1, tensor_type);
  value.bytes(1, name);
  value.message(2, type);
  return value;
}

}  // namespace

std::string OnnxGraph::floats(const std::string& label, std::span<const float> values,
                              const std::vector<std::int64_t>& shape) {
  std::string name = fresh(label);
  graph_.message(5, onnx_tensor(name, values, shape, float32));
  return name;
}

std::string OnnxGraph::integers(const std::string& label, std::span<const std::int64_t> values) {
  std::string name = fresh(label);
  graph_.message(5, onnx_tensor(name, values, {static_cast<std::int64_t>(values.size())}, int64));
  return name;
}

std::string OnnxGraph::indices(const std::string& label, std::span<const std::uint32_t> values) {
  const std::vector<std::int64_t> wide(values.begin(), values.end());
  return integers(label, wide);
}

std::string OnnxGraph::number(const std::string& label, float value) {
  return floats(label, {&value, 1}, {});
}

std::string OnnxGraph::node(const std::string& type, const std::string& label, const std::vector<std::string>& inputs,
                            const std::vector<OnnxAttribute>& attributes) {
  std::string name = fresh(label);
  ProtobufMessage made;
  for (const std::string& input : inputs) made.bytes(1, input);
  made.bytes(2, name);
  made.bytes(3, name);
  made.bytes(4, type);
  for (const OnnxAttribute& attribute : attributes) made.message(5, onnx_attribute(attribute));
  graph_.message(1, made);
  ++nodes_;
  return name;
}

std::string OnnxGraph::polynomial(const std::string& label, const std::string& x, std::span<const float> coefficients) {
  std::string value = number(label, coefficients[0]);
  for (const float next : coefficients.subspan(1))
    value = node("Add", label, {node("Mul", label, {value, x}), number(label, next)});
  return value;
}

std::string OnnxGraph::sum_in_order(const std::string& label, const std::string& numbers, std::int64_t axis,
                                    std::size_t count) {
  const std::string along = fresh(label);
  graph_.message(5, onnx_tensor<std::int64_t>(along, {&axis, 1}, {}, int64));
  const std::string sums = node("CumSum", label, {numbers, along});
  const auto last = static_cast<std::int64_t>(count) - 1;
  return node("Gather", label, {sums, integers(label, {&last, 1})}, {{"axis", {axis}}});
}

void OnnxGraph::input(const std::string& name, const std::vector<std::int64_t>& shape) {
  graph_.message(11, onnx_value(name, shape));
}

void OnnxGraph::output(const std::string& name, const std::string& tensor, const std::vector<std::int64_t>& shape) {
  ProtobufMessage made;
  made.bytes(1, tensor);
  made.bytes(2, name);
  made.bytes(3, name);
  made.bytes(4, "Identity");
  graph_.message(1, made);
  ++nodes_;
  graph_.message(12, onnx_value(name, shape));
}

void OnnxGraph::write(const std::filesystem::path& path, const std::string& name, const std::string& producer_version,
                      const std::vector<std::pair<std::string, std::string>>& properties) const {
  ProtobufMessage named, head, tail, opset;
  named.bytes(2, name);  // fields of a message may come in any order
  head.number(1, ir_version);
  head.bytes(2, "FaceBaker");
  head.bytes(3, producer_version);
  opset.number(2, operator_set);
  head.message(8, opset);
  for (const auto& [key, text] : properties) {
    ProtobufMessage property;
    property.bytes(1, key);
    property.bytes(2, text);
    tail.message(14, property);
  }
  const std::uint64_t graph_bytes = named.content().size() + graph_.content().size();
  head.prefix(7, graph_bytes);
  const std::uint64_t bytes = head.content().size() + graph_bytes + tail.content().size();
  if (bytes > largest_file)
    fail(Status::limit, "%s: %llu bytes are more than the 2 GB that an ONNX file holds", shown(path).c_str(),
         static_cast<unsigned long long>(bytes));
  AtomicFile file(path);
  for (const std::string* part : {&head.content(), &named.content(), &graph_.content(), &tail.content()})
    file.write(std::as_bytes(std::span(*part)));
  file.commit();
}

}  // namespace fb::bake

// A graph of ONNX operators that is built node by node. https://onnx.ai: the messages and their field numbers are those
// of onnx.proto, IR version 7; operators are those of operator set 13.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bake/export/protobuf_message.h"

namespace fb::bake {

// A whole-number attribute of a node: one, or a list of them.
struct OnnxAttribute {
  std::string name;
  std::vector<std::int64_t> values;
  bool list = false;
};

class OnnxGraph {
 public:
  // Tensors are known by their names; these functions give that of what they have added. Names are made of `label` and
  // a number.
  std::string floats(const std::string& label, std::span<const float> values, const std::vector<std::int64_t>& shape);
  std::string integers(const std::string& label, std::span<const std::int64_t> values);  // a row
  std::string indices(const std::string& label, std::span<const std::uint32_t> values);  // the same, of indices
  std::string number(const std::string& label, float value);                             // a scalar
  std::string node(const std::string& type, const std::string& label, const std::vector<std::string>& inputs,
                   const std::vector<OnnxAttribute>& attributes = {});
  // The value of a polynomial of each x, by Horner's rule, from the highest power down.
  std::string polynomial(const std::string& label, const std::string& x, std::span<const float> coefficients);

  // The sums along an axis of so many numbers, which is kept, of length 1: from the first number to the last, as
  // ReduceSum need not add them.
  std::string sum_in_order(const std::string& label, const std::string& numbers, std::int64_t axis, std::size_t count);

  // An input or output of the whole: float32, a dimension of a batch, which is named "n", and then `shape`.
  void input(const std::string& name, const std::vector<std::int64_t>& shape);
  // The tensor gets `name`.
  void output(const std::string& name, const std::string& tensor, const std::vector<std::int64_t>& shape);

  std::size_t nodes() const { return nodes_; }

  // Writes the model, complete or not at all. properties: keys and texts beside it. Fails with limit on more than the
  // 2 GB of a Protocol Buffers file.
  void write(const std::filesystem::path& path, const std::string& name, const std::string& producer_version,
             const std::vector<std::pair<std::string, std::string>>& properties) const;

 private:
  std::string fresh(const std::string& label) { return label + "." + std::to_string(next_++); }

  ProtobufMessage graph_;
  std::size_t nodes_ = 0, next_ = 0;
};

}  // namespace fb::bake

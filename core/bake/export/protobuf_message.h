// Writes messages of Protocol Buffers, as far as an ONNX file needs them (protobuf.dev, "Encoding"). No library does
// it: libfacebaker_bake depends on the C library alone, and two copies of protobuf's generated code for onnx.proto in
// one process, ours and that of a host that runs ONNX itself, refuse to start.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace fb::bake {

class ProtobufMessage {
 public:
  // A whole number that is not negative, or two's complement: -1 has ten bytes.
  void number(std::uint32_t field, std::int64_t value) {
    varint(std::uint64_t(field) << 3);
    varint(static_cast<std::uint64_t>(value));
  }
  // A text, the bytes of an array, or a message.
  void bytes(std::uint32_t field, std::string_view content) {
    prefix(field, content.size());
    bytes_ += content;
  }
  void message(std::uint32_t field, const ProtobufMessage& inner) { bytes(field, inner.bytes_); }
  // What comes before `size` bytes of such a field that are written elsewhere.
  void prefix(std::uint32_t field, std::uint64_t size) {
    varint((std::uint64_t(field) << 3) | 2);
    varint(size);
  }

  const std::string& content() const { return bytes_; }

 private:
  void varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_ += static_cast<char>((value & 0x7f) | 0x80);
    bytes_ += static_cast<char>(value);
  }

  std::string bytes_;
};

}  // namespace fb::bake

#include "archive/writer.h"
#include "golden_edits.h"

namespace fb {
namespace {

// The smallest model with one feature, and one region of two layers of 8-bit weights, which moves nothing.
PackedModel small_network(std::uint32_t inner = 1) {
  PackedModel model = smallest();
  model.features = {{Feature::Kind::identity, 0, 1, 0}};
  const auto layer = [](std::uint32_t inputs, std::uint32_t outputs) {
    return PackedLayer{inputs,
                       outputs,
                       Activation::linear,
                       false,
                       false,
                       std::pmr::vector<std::int16_t>(inputs * outputs, 1),
                       std::vector<float>(outputs, 1),
                       std::vector<float>(outputs, 1)};
  };
  model.regions = {{"r", {0}, {layer(1, inner), layer(inner, 1)}, {}}};
  model.columns = 1;
  return model;
}

// The smallest model with one column, in the first row block, of one row.
PackedModel small_basis(bool is_16_bit) {
  PackedModel model = smallest();
  model.features = {{Feature::Kind::identity, 0, 1, 0}};
  model.direct = {0};
  model.columns = 1;
  model.row_blocks = {{0, 1, {{0, is_16_bit, 1}}, {1}}, {1, 5, {}, {}}};
  return model;
}

// Symbols of two values, of which each takes a bit, and none is there.
Bytes symbols_without_words(std::size_t tables, std::size_t parts, std::size_t table) {
  Bytes bytes = constant_symbols(tables, parts, table, 0);
  const std::size_t at = 1 + 2 * table;
  patch(bytes, at, std::uint16_t(2));
  const Bytes half = {std::byte(0x80), std::byte(4)};  // 512
  std::copy(half.begin(), half.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at + 3));
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at + 5), half.begin(), half.end());
  return bytes;
}

void write_rejected_features(const RejectedWriter& out) {
  // Nine features; direct coefficients at byte 101, region "face" at 117, "brow" at 339.
  out.patched("corrupt-feature-threshold-infinite.fbk", "network", 31, infinity);
  out.patched("corrupt-feature-fall-nan.fbk", "network", 79, nan_bits);
  out.patched("corrupt-direct.fbk", "network", 105, std::uint32_t(9));
  out.patched("corrupt-region-feature.fbk", "network", 129, std::uint32_t(9));
  // Its gate features are 0, 1, 4 and 5; 2 is a ramp.
  constexpr std::size_t gate = 363;
  out.patched("corrupt-gate-feature.fbk", "network", gate, std::uint32_t(9));
  out.patched("corrupt-gate-kind.fbk", "network", gate + 12, std::uint32_t(2));
  out.patched("corrupt-gate-order.fbk", "network", gate + 4, std::uint32_t(0));
}

void write_rejected_layers(const RejectedWriter& out) {
  const PackedModel model = small_network();
  // Layers begin with inputs and outputs, kind and flags, and take 18 bytes; there are two from byte 46 on.
  constexpr std::size_t layers = 42, first = layers + 4, second = first + 18, bias = 10, scale = 14;
  const auto write = [&](const char* file, const std::function<void(Bytes&)>& change, std::uint32_t inner = 1) {
    out.write(file, edited(
                        [&](ArchiveEditor& archive) {
                          change(archive["network"].stored);
                          archive["network"].set(archive["network"].stored);
                          archive["weights"].set(constant_symbols(9, 1, 9, 0));
                        },
                        small_network(inner)));
  };
  write("corrupt-layer-inputs.fbk", [](Bytes& b) { patch(b, second, std::uint32_t(2)); });
  // A first layer of two outputs, so that there are 18 bytes a layer.
  const auto drop_outputs = [](Bytes& b) {
    constexpr std::size_t last = first + 10 + 16;
    patch(b, last + 4, std::uint32_t(0));
    b.resize(last + bias);
  };
  write("corrupt-layer-outputs.fbk", drop_outputs, 2);
  write("corrupt-layers-none.fbk", [](Bytes& b) {
    patch(b, layers, std::uint32_t(0));
    b.resize(first);
  });
  out.patched("corrupt-layer-skip.fbk", "network", first + 9, std::uint8_t(1), small_network(2));
  out.patched("corrupt-layer-bias.fbk", "network", second + bias, infinity, model);
  out.patched("corrupt-layer-scale.fbk", "network", second + scale, nan_bits, model);
  PackedModel large = model;
  large.regions[0].layers[1].weights = {127};
  large.regions[0].layers[1].scales = {3e38f};
  out.write("unproven-rest.fbk", archive::write_archive(large, {}));
}

void write_rejected_symbols(const RejectedWriter& out) {
  const auto weights = [&](const char* file, const Bytes& symbols) {
    out.replaced(file, "weights", symbols, small_network());
  };
  weights("corrupt-weight-8-bit.fbk", constant_symbols(9, 1, 2, 255));
  weights("corrupt-weights-few.fbk", symbols_without_words(9, 1, 0));
  Bytes symbols = constant_symbols(9, 1, 0, 0);
  patch(symbols, 5, std::uint8_t(7));
  weights("corrupt-frequencies-small.fbk", symbols);
  symbols = constant_symbols(9, 1, 0, 255);
  patch(symbols, 1, std::uint16_t(2));
  symbols.insert(symbols.begin() + 6, std::byte(0));
  weights("corrupt-symbol.fbk", symbols);
  const auto values = [&](const char* file, bool is_16_bit, const Bytes& coded) {
    out.replaced(file, "basis-values", coded, small_basis(is_16_bit));
  };
  values("corrupt-tables-24.fbk", false, constant_symbols(24, 4, 24, 0));
  values("corrupt-tables-90.fbk", false, constant_symbols(90, 4, 90, 0));
  values("corrupt-values-few.fbk", false, symbols_without_words(26, 4, 25));
  values("corrupt-axis.fbk", false, constant_symbols(26, 4, 25, 3));
  // Class 16, and ten raw bits, 0, of a state that becomes the final one.
  Bytes large = constant_symbols(26, 4, 25, 41);
  patch(large, 1 + 26 * 2 + 3 + 16, std::uint32_t(65536 << 10));
  values("corrupt-value-16-bit.fbk", true, large);
}

void write_rejected_columns(const RejectedWriter& out) {
  // No columns, no order, one row block; no scales.
  constexpr std::size_t blocks = 8, rows = 12, scales = 16;
  const auto write = [&](const char* file, const std::function<void(Bytes&)>& change) {
    out.write(file, changed("basis", change, smallest()));
  };
  write("corrupt-columns-more.fbk", [](Bytes& b) {
    patch(b, 0, std::uint32_t(1));
    insert(b, scales, {0});
  });
  write("corrupt-row-block-empty.fbk", [](Bytes& b) {
    patch(b, blocks, std::uint32_t(2));
    erase(b, rows, 4);
    insert(b, rows, {6, 0});
  });
  write("corrupt-scales-more.fbk", [](Bytes& b) {
    patch(b, scales, std::uint32_t(1));
    append(b, 1.0f);
  });
  // The scale, at the end, becomes 2^120.
  Bytes contents;
  edited([&](ArchiveEditor& archive) { contents = archive["basis"].stored; }, small_basis(true));
  contents.back() = std::byte(0x7b);
  out.replaced("corrupt-scale-16-bit.fbk", "basis", contents, small_basis(true));
}

}  // namespace

void write_rejected_behaviour(const RejectedWriter& out) {
  write_rejected_features(out);
  write_rejected_layers(out);
  write_rejected_symbols(out);
  write_rejected_columns(out);
  out.patched("corrupt-tables.fbk", "weights", 0, std::uint8_t(64));
  out.patched("unsupported-feature.fbk", "network", 4, std::uint8_t(17));
  out.patched("corrupt-feature-control.fbk", "network", 5, std::uint32_t(5));
  out.patched("corrupt-feature-scale.fbk", "network", 9, std::uint32_t(0x7fc00000));
  out.patched("corrupt-feature-threshold.fbk", "network", 31, -1.0f);
  out.patched("corrupt-feature-fall.fbk", "network", 79, -1.0f);
  out.patched("corrupt-feature-loop.fbk", "network", 84, std::uint32_t(7));
  out.patched("corrupt-gate-slope.fbk", "network", 157, 0.0f);
  out.patched("corrupt-gate-slope-infinite.fbk", "network", 157, std::uint32_t(0x7f800000));
  out.patched("unsupported-activation.fbk", "network", 173, std::uint8_t(9));
  out.patched("unsupported-layer-flags.fbk", "network", 174, std::uint8_t(4));
  out.patched("corrupt-columns.fbk", "basis", 0, std::uint32_t(3));
  out.patched("corrupt-ordered.fbk", "basis", 4, std::uint32_t(2));
  out.patched("corrupt-order.fbk", "basis", 8, std::uint8_t(0));
  out.patched("corrupt-rows.fbk", "basis", 132, std::uint8_t(64));
  out.patched("corrupt-segment-block.fbk", "basis", 160, std::uint8_t(9));
  out.patched("corrupt-segment-twice.fbk", "basis", 161, std::uint8_t(0));
  out.patched("corrupt-segment-table.fbk", "basis", 192, std::uint8_t(0xfe));
  out.patched("corrupt-segment-scale.fbk", "basis", 192, std::uint8_t(1));
  out.write("corrupt-scale.fbk", changed("basis", [](Bytes& b) { patch_infinity(b, 204); }));
  out.patched("corrupt-frequencies.fbk", "weights", 4, std::uint16_t(0x7fff));
  out.write("corrupt-few-words.fbk", changed("basis-values", [](Bytes& b) { b.resize(b.size() - 2); }));
  // Without weights, the word counts follow 9 tables that have no frequencies.
  const auto add_word = [](Bytes& b) {
    patch(b, 1 + 9 * 2 + 3 * 4, std::uint32_t(1));
    b.resize(b.size() + 2);
  };
  out.write("corrupt-many-words.fbk", changed("weights", add_word, smallest()));
  const auto coded = [&](const char* file, const Bytes& symbols, const char* section = "basis-values") {
    out.write(file, changed(section, [&](Bytes& b) { b = symbols; }));
  };
  const auto values = [](std::size_t table, std::uint8_t symbol) { return constant_symbols(26, 4, table, symbol); };
  coded("corrupt-predictor.fbk", values(0, 91));
  coded("corrupt-value.fbk", values(25, 31));
  coded("corrupt-class.fbk", values(25, 43));
  coded("corrupt-weight.fbk", constant_symbols(9, 1, 6, 255), "weights");
  Bytes states = values(25, 0);
  patch(states, states.size() - 4, std::uint32_t(65535));
  coded("corrupt-state.fbk", states);
  patch(states, states.size() - 4, std::uint32_t(65537));
  coded("corrupt-final-state.fbk", states);
}

void write_rejected_texts_and_proofs(const RejectedWriter& out) {
  constexpr std::size_t hashes_at = 4 + 11 * 5 * 4, vertices_at = hashes_at + 11 * 8 + 4;
  out.write("corrupt-zero-byte.fbk", changed("licence", [](Bytes& b) { b[3] = std::byte(0); }));
  out.patched("corrupt-proof-control.fbk", "proof", 4, std::uint32_t(0x7fc00000));
  out.patched("corrupt-proof-vertex.fbk", "proof", vertices_at, std::uint32_t(30));
  // Valid archives whose proof does not hold.
  out.patched("unproven-hash.fbk", "proof", hashes_at + 3 * 8, std::uint64_t(1));
  out.patched("unproven-position.fbk", "proof", vertices_at + 16 * 4 + 40, 1e9f);
}

}  // namespace fb

// What evaluation needs of a packed model, levels of detail excepted, and poses as raw bytes of this machine, so that
// programs that evaluate them need none of the archive's libraries.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <type_traits>
#include <vector>

#include "base/status.h"
#include "model/packed_model.h"

namespace fb {

// Writes or reads, with one list of fields for both.
class Dump {
 public:
  Dump(const char* path, bool reads) : file_(std::fopen(path, reads ? "rb" : "wb")), reads_(reads) {
    if (!file_) fail(Status::io, "%s: cannot be opened", path);
  }
  ~Dump() { std::fclose(file_); }
  Dump(const Dump&) = delete;
  Dump& operator=(const Dump&) = delete;

  void all(PackedModel& m, std::vector<float>& controls) {
    list(m.schema.controls, [this](Control& c) { each(c.name, c.minimum, c.maximum, c.rest, c.group); });
    list(m.schema.channels, [this](Channel& c) { each(c.name, c.minimum, c.maximum, c.rest, c.scale); });
    each(m.rest.points, m.rest.polygon_sizes, m.rest.polygon_corners, m.rest.uvs, m.rest.uv_corners,
         m.rest.carrier_vertices);
    list(m.rest.parts, [this](MeshPart& p) { each(p.name, p.vertices, p.polygons, p.materials); });
    driven(m.rest.driven);
    list(m.features, [this](Feature& f) { each(f.kind, f.control, f.scale, f.threshold, f.fall, f.first, f.second); });
    item(m.direct);
    list(m.regions, [this](PackedRegion& r) {
      each(r.name, r.features, r.gate.features, r.gate.slope);
      list(r.layers, [this](PackedLayer& l) {
        each(l.inputs, l.outputs, l.activation, l.skip, l.wide, l.weights, l.scales, l.bias);
      });
    });
    each(m.columns, m.order);
    list(m.row_blocks, [this](PackedRowBlock& g) {
      each(g.first_row, g.row_count, g.values);
      list(g.columns, [this](PackedColumn& c) { each(c.column, c.wide, c.scale); });
    });
    list(m.exact, [this](ExactPose& p) { each(p.name, p.controls, p.falloff, p.step, p.values); });
    list(m.character.sockets, [this](Socket& s) { each(s.name, s.vertices, s.weights, s.frame); });
    item(controls);
  }

 private:
  void driven(DrivenJoints& d) {
    list(d.joints, [this](DrivenJoint& j) { each(j.name, j.parent, j.numbers, j.rest, j.outer_rotations); });
    each(d.scales, d.skin.influences, d.skin.joints, d.skin.weights);
  }
  void bytes(void* at, std::size_t count) {
    if (count == 0) return;  // `at` may be null then
    const std::size_t done = reads_ ? std::fread(at, 1, count, file_) : std::fwrite(at, 1, count, file_);
    if (done != count) fail(Status::io, "the dump is truncated");
  }
  template <class List>
  void size(List& list) {
    std::uint64_t count = list.size();
    bytes(&count, sizeof count);
    if (reads_) list.resize(static_cast<std::size_t>(count));
  }
  template <class Item>
  requires std::is_trivially_copyable_v<Item>
  void item(Item& value) { bytes(&value, sizeof value); }
  void item(std::string& text) {
    size(text);
    bytes(text.data(), text.size());
  }
  template <class Item, class Memory>
  void item(std::vector<Item, Memory>& values) {
    size(values);
    bytes(values.data(), values.size() * sizeof(Item));
  }
  template <class... Items>
  void each(Items&... items) {
    (item(items), ...);
  }
  template <class Item, class Memory, class Each>
  void list(std::vector<Item, Memory>& items, Each&& each_item) {
    size(items);
    for (Item& i : items) each_item(i);
  }

  std::FILE* file_;
  bool reads_;
};

}  // namespace fb

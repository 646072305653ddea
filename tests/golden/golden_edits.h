// What the golden archives are made by: models, and changes to archives that no writer would make.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>

#include "archive/archive_editor.h"
#include "base/file.h"
#include "test_models.h"

namespace fb {

// Bits of floats, and the number that stands for no material, joint or control.
inline constexpr std::uint32_t infinity = 0x7f800000, nan_bits = 0x7fc00000, minus_zero = 0x80000000;
inline constexpr std::uint32_t no_item = 0xffffffff;

using Edit = std::function<void(ArchiveEditor&)>;

Bytes text(const std::string& s);

// The model's archive, with a proof and texts.
Bytes with_proof(const PackedModel& model);
Bytes edited(const Edit& edit, const PackedModel& model = tiny_packed_model());
// With the contents of a section changed.
Bytes changed(const char* section, const std::function<void(Bytes&)>& change,
              const PackedModel& model = tiny_packed_model());
Bytes without(const std::string& section, const PackedModel& model);
// With as many sections, the last ones unknown and empty.
Bytes many_sections(std::size_t count);

void deflate_section(ArchiveEditor::Section& section, int effort = 1);
// The first string `from` of a section's contents becomes `to`.
void rename(Bytes& contents, const std::string& from, const std::string& to);
void insert(Bytes& contents, std::size_t at, std::initializer_list<std::uint32_t> numbers);
void erase(Bytes& contents, std::size_t at, std::size_t count);
Bytes numbers(std::initializer_list<std::uint32_t> list);

// The smallest valid model: two vertices and one control that moves nothing.
PackedModel smallest();
// Positions on a grid and 20 quads coded along triangles, the vertices in another order than Draco's.
PackedModel regular(bool polygons);
// With a chain of 256 driven joints, of names of one byte or more, and beside it what there are more.
PackedModel deep_chain(std::uint32_t joints);
// With two driven joints: "all" has as many outer rotations as there may be, the first with two numbers and the others
// with one; that of the other is 0 in every pose, which a zero of its frame has the sign of.
PackedModel many_rotations();
PackedModel with_uvs(void (*add_uvs)(Mesh&));

// Draco data whose numbers and frequencies take more bytes than they need.
Bytes archive_of_long_numbers();

// Writes files into the folder of rejected archives.
class RejectedWriter {
 public:
  explicit RejectedWriter(const std::filesystem::path& folder) : folder_(folder) {}

  void write(const char* name, const Bytes& bytes) const { write_file(folder_ / name, bytes); }
  // The tiny model, or another, with the number at byte `at` of a section's contents replaced.
  template <class T>
  void patched(const char* name, const char* section, std::size_t at, T value,
               const PackedModel& model = tiny_packed_model()) const {
    write(name, changed(
                    section, [&](Bytes& b) { patch(b, at, value); }, model));
  }
  // With the first string `from` of a section replaced.
  void renamed(const char* name, const char* section, const char* from, const char* to,
               const PackedModel& model) const {
    write(name, changed(
                    section, [&](Bytes& b) { rename(b, from, to); }, model));
  }
  // With other contents of a section, and without a proof, which might not hold.
  void replaced(const char* name, const char* section, const Bytes& contents, const PackedModel& model) const;

 private:
  std::filesystem::path folder_;
};

// The rejected archives, by what they break.
void write_rejected_containers(const RejectedWriter& out);
void write_rejected_sections(const RejectedWriter& out);
void write_rejected_geometry(const RejectedWriter& out);
void write_rejected_draco(const RejectedWriter& out);
void write_rejected_characters(const RejectedWriter& out);
void write_rejected_bodies(const RejectedWriter& out);
void write_rejected_errors(const RejectedWriter& out);
void write_rejected_exact_poses(const RejectedWriter& out);
void write_rejected_joints(const RejectedWriter& out);
void write_rejected_levels(const RejectedWriter& out);
void write_rejected_behaviour(const RejectedWriter& out);
void write_rejected_texts_and_proofs(const RejectedWriter& out);

}  // namespace fb

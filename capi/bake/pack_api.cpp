#include "archive/migrate/version_0_2.h"
#include "archive/writer.h"
#include "bake/authoring.h"
#include "bake/compress/step_scaling.h"
#include "bake/measure/certificate.h"
#include "base/file.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

using fb::archive::Archive;

std::vector<std::byte> bytes_of(const fb_pack_desc& desc) {
  if (!desc.path == !desc.bytes) fail(Status::invalid_argument, "fb_pack_desc: either path or bytes are needed");
  if (desc.path) return fb::read_file(desc.path);
  const auto* first = static_cast<const std::byte*>(desc.bytes);
  return {first, first + desc.byte_count};
}

Archive read_any(std::span<const std::byte> bytes) {
  return fb::archive::is_version_0_2(bytes) ? fb::archive::read_version_0_2(bytes) : fb::archive::read_archive(bytes);
}

// Scales the steps of the basis, as the description's targets need.
void scale_steps(Archive& face, const fb_pack_desc& desc, fb_pack_result& result) {
  constexpr std::uint64_t other_seed = 0x9e3779b9;  // poses that the proof does not have
  std::vector<float> poses = fb::bake::make_proof(face.model, desc.seed).controls;
  const std::vector<float> more = fb::bake::make_proof(face.model, desc.seed ^ other_seed).controls;
  poses.insert(poses.end(), more.begin(), more.end());
  struct Scaled {
    Archive face;
    fb::bake::Errors moved;
  };
  const auto with = [&](double factor) {
    Scaled scaled{face, {}};
    if (factor <= 1) return scaled;
    scaled.face.model = fb::bake::with_scaled_steps(face.model, factor);
    scaled.moved = fb::bake::packing_errors(face.model, scaled.face.model, poses);
    fb::bake::note_repacking(scaled.face.text.certificate, scaled.moved);
    scaled.face.proof = fb::bake::make_proof(scaled.face.model, desc.seed);
    return scaled;
  };
  const fb::bake::StepScaling choice = fb::bake::choose_step_scaling(
      desc.max_bytes, desc.max_error,
      [&](double factor) {
        const Archive scaled = with(factor).face;
        return std::uint64_t(fb::archive::write_archive(scaled.model, scaled.proof, scaled.text).size());
      },
      [&](double factor) { return with(factor).moved.max; });
  auto [chosen, moved] = with(choice.factor);
  face = std::move(chosen);
  result.within_limits = desc.max_bytes > 0 ? choice.bytes <= desc.max_bytes : choice.error <= desc.max_error;
  if (!result.within_limits && !desc.force)
    fail(Status::limit, "%llu bytes cannot be had: the fewest are %llu",
         static_cast<unsigned long long>(desc.max_bytes), static_cast<unsigned long long>(choice.bytes));
  result.step_factor = choice.factor;
  result.max_error = desc.max_error;
  result.displacement = c_errors(moved);
}

}  // namespace

extern "C" {

void fb_pack_desc_fill(fb_pack_desc* to, uint32_t struct_size) {
  fb_pack_desc defaults = {};
  defaults.seed = 1;
  fill_struct(to, struct_size, defaults);
}

fb_status fb_pack(const fb_pack_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_pack_desc known = read_struct(*desc, fb_pack_desc_init, "fb_pack_desc");
    const std::string name = known.path ? known.path : "memory";
    const std::vector<std::byte> bytes = bytes_of(known);
    Archive face = fb::with_context(name, [&] { return read_any(bytes); });
    auto made = std::make_unique<fb_report>();
    fb_pack_result result = {};
    result.within_limits = 1;
    result.step_factor = 1;
    result.bytes_before = bytes.size();
    result.format_before = face.format_version;
    if (known.licence) face.text.licence = known.licence;
    if (face.proof.hashes.empty()) face.proof = fb::bake::make_proof(face.model, known.seed);
    if (known.max_bytes > 0 || known.max_error > 0) scale_steps(face, known, result);
    made->packed = fb::archive::write_archive(face.model, face.proof, face.text);
    fb::bake::verify_archive(made->packed);
    if (known.out) fb::write_file(known.out, made->packed);
    result.archive = made->packed.data();
    result.archive_bytes = made->packed.size();
    result.format = fb::archive::archive_format_version();
    made->pack = result;
    made->json = pack_json(name, text_or_empty(known.out), result);
    hand_over(std::move(made), report);
  });
}

}  // extern "C"

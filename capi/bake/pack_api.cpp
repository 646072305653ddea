#include "bake/authoring.h"
#include "bake/pipeline/repack.h"
#include "bake/rig/about.h"
#include "base/file.h"
#include "base/output_lock.h"
#include "base/shown_path.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

std::vector<std::byte> bytes_of(const fb_pack_desc& desc) {
  if (!desc.path == !desc.bytes) fail(Status::invalid_argument, "fb_pack_desc: either path or bytes are needed");
  if (desc.path) return fb::read_file(desc.path);
  const auto* first = static_cast<const std::byte*>(desc.bytes);
  return {first, first + desc.byte_count};
}

fb::bake::RepackOptions options_of(const fb_pack_desc& desc) {
  fb::bake::RepackOptions options;
  options.max_bytes = desc.max_bytes;
  options.max_error = desc.max_error;
  options.force = desc.force != 0;
  options.seed = desc.seed;
  options.licence = text_or_empty(desc.licence);
  options.about = text_or_empty(desc.about);
  fb::bake::merged_about("", options.about);  // what is wrong with it is no fault of the archive
  options.thumbnail = bytes_or_none(desc.thumbnail, desc.thumbnail_bytes);
  options.sockets = text_or_empty(desc.sockets);
  return options;
}

fb_pack_result result_of(const fb::bake::RepackResult& repacked, const std::vector<std::byte>& archive) {
  fb_pack_result result = {};
  result.within_limits = repacked.within_limits ? 1 : 0;
  result.archive = archive.data();
  result.archive_bytes = archive.size();
  result.bytes_before = repacked.source_bytes;
  result.format_before = repacked.source_version;
  result.format = fb::archive::format_version_of(archive);
  result.step_factor = repacked.factor;
  result.max_error = repacked.max_error;
  result.displacement = c_errors(repacked.displacement);
  return result;
}

}  // namespace

extern "C" {

void fb_pack_desc_fill(fb_pack_desc* to, uint32_t struct_size) {
  fb_pack_desc defaults = {};
  defaults.seed = fb::bake::RepackOptions().seed;
  fill_struct(to, struct_size, defaults);
}

fb_status fb_pack(const fb_pack_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_pack_desc known = read_struct(*desc, fb_pack_desc_init, "fb_pack_desc");
    std::optional<fb::OutputLock> lock;
    if (known.out) lock = fb::OutputLock::of_file(known.out);
    const std::vector<std::byte> bytes = bytes_of(known);
    const std::string name = known.path ? known.path : "memory";
    HostProgress progress(known.callbacks);
    const fb::bake::RepackOptions options = options_of(known);
    fb::bake::RepackResult repacked =
        fb::with_context(fb::shown(name), [&] { return fb::bake::repack(bytes, options, progress); });
    if (known.out) fb::bake::write_verified_archive(known.out, repacked.archive);
    auto made = std::make_unique<fb_report>();
    made->packed = std::move(repacked.archive);
    made->pack = result_of(repacked, made->packed);
    made->json = pack_json(name, text_or_empty(known.out), *made->pack);
    hand_over(std::move(made), report);
  });
}

}  // extern "C"

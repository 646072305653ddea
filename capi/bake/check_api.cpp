#include "bake/authoring.h"
#include "bake/check/check_dataset.h"

using namespace fb::capi;

extern "C" {

void fb_check_desc_fill(fb_check_desc* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_check(const fb_check_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_check_desc known = read_struct(*desc, fb_check_desc_init, "fb_check_desc");
    require(known.directory, "fb_check_desc: directory");
    HostProgress progress(known.callbacks);
    const fb::bake::DatasetCheck found =
        fb::bake::check_dataset(known.directory, parallel_of(known.threads, &progress), progress);
    fb_check_result result = {};
    result.bakeable = found.bakeable ? 1 : 0;
    for (const fb::bake::Finding& finding : found.findings) ++(finding.fault ? result.faults : result.warnings);
    for (const fb::bake::CheckedClip& clip : found.clips) {
      result.poses += clip.frames;
      result.evaluated += clip.evaluated;
    }
    auto made = std::make_unique<fb_report>();
    made->json = check_json(known.directory, found);
    made->details = check_details_json(found);
    made->check = result;
    hand_over(std::move(made), report);
  });
}

}  // extern "C"

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
    const fb::DatasetFigures found =
        fb::bake::check_dataset(known.directory, parallel_of(known.threads, &progress), progress);
    fb_check_result result = {};
    result.bakeable = found.bakeable ? 1 : 0;
    result.faults = found.faults.size();
    result.warnings = found.warnings.size();
    result.poses = found.poses;
    result.evaluated = found.evaluated;
    auto made = std::make_unique<fb_report>();
    made->json = dataset_json(found, false);
    made->details = dataset_json(found, true);
    made->check = result;
    hand_over(std::move(made), report);
  });
}

}  // extern "C"

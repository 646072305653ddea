#include "bake/authoring.h"
#include "bake/pipeline/compare.h"

using namespace fb::capi;

namespace {

std::vector<std::string> methods_of(const fb_compare_desc& desc) {
  if (!desc.methods) return {"linear", "paper-tuned", "hero"};
  std::vector<std::string> methods;
  for (std::uint32_t m = 0; m < desc.method_count; ++m) {
    require(desc.methods[m], "fb_compare_desc: one of methods");
    methods.emplace_back(desc.methods[m]);
  }
  return methods;
}

}  // namespace

extern "C" {

void fb_compare_desc_fill(fb_compare_desc* to, uint32_t struct_size) {
  fb_compare_desc defaults = {};
  fill_options(defaults);
  fill_struct(to, struct_size, defaults);
}

fb_status fb_compare(const fb_compare_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    require(report, "report");
    const fb_compare_desc known = read_struct(*desc, fb_compare_desc_init, "fb_compare_desc");
    fb::bake::Source& source = source_of(known.source, "fb_compare_desc: source");
    HostProgress progress(known.callbacks);
    fb::bake::BakeOptions options = training_options(known, "fb_compare_desc", progress);
    auto made = std::make_unique<fb_report>();
    if (options.work.empty()) options.work = made->folder.emplace().path();
    fb::bake::CompareReport compared = fb::bake::compare(source, methods_of(known), options, progress);
    made->recorded.source = std::move(compared.recorded);
    made->faces = std::move(compared);
    made->json = faces_json(made->faces, false);
    *report = made.release();
  });
}

}  // extern "C"

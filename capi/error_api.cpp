#include <facebaker/facebaker.h>

#include "loaded_model.h"

extern "C" {

uint32_t fb_error_region_count(const fb_model* model) {
  return model ? static_cast<uint32_t>(model->error_regions.size()) : 0;
}

const char* fb_error_region_name(const fb_model* model, uint32_t index) {
  return index < fb_error_region_count(model) ? model->error_regions[index].name.c_str() : nullptr;
}

const uint32_t* fb_error_vertex_regions(const fb_model* model) {
  return fb_error_region_count(model) > 0 ? model->evaluator.error_regions().data() : nullptr;
}

}  // extern "C"

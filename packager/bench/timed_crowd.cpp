#include "bench/timed_crowd.h"

namespace fb::tool {

TimedCrowd::TimedCrowd(const fb_archive_info& archive, std::size_t faces) : batches_(faces), items_(faces) {
  for (std::size_t f = 0; f < faces; ++f) {
    const facebaker::Model& model = models_.emplace_back(archive.bytes, archive.byte_count);
    std::vector<float>& positions = positions_.emplace_back(3 * std::size_t(model.vertex_count()));
    fb_batch_desc& batch = batches_[f];
    fb_batch_desc_init(&batch);
    batch.poses = 1;
    batch.control_floats = model.control_count();
    batch.positions = positions.data();
    batch.position_floats = positions.size();
  }
  for (std::size_t f = 0; f < faces; ++f) {
    fb_scratch* scratch = nullptr;
    facebaker::check(fb_scratch_create_single(models_[f].get(), 1, &scratch));
    scratches_.emplace_back(scratch);
    items_[f] = {models_[f].get(), scratch, &batches_[f]};
  }
}

void TimedCrowd::evaluate(std::size_t frame, std::span<const float> controls, std::uint32_t threads) {
  for (std::size_t f = 0; f < items_.size(); ++f) {
    const std::size_t width = batches_[f].control_floats, poses = controls.size() / width;
    batches_[f].controls = controls.data() + (frame + f) % poses * width;
  }
  fb_many_desc desc;
  fb_many_desc_init(&desc);
  desc.threads = threads;
  desc.items = items_.data();
  desc.item_count = static_cast<std::uint32_t>(items_.size());
  facebaker::evaluate(desc);
}

}  // namespace fb::tool

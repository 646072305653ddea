#include "bench/timed_crowd.h"

#include <algorithm>

namespace fb::tool {

TimedCrowd::TimedCrowd(const fb_archive_info& archive, std::size_t faces, std::size_t models, std::uint32_t workers,
                       bool normals)
    : scratches_(workers), batches_(faces), items_(faces) {
  for (std::size_t m = 0; m < std::min(models, faces); ++m)
    scratches_.add(models_.emplace_back(archive.bytes, archive.byte_count));
  for (std::size_t f = 0; f < faces; ++f) {
    const facebaker::Model& model = models_[f % models];
    std::vector<float>& positions = positions_.emplace_back(3 * std::size_t(model.vertex_count()));
    fb_batch_desc& batch = batches_[f];
    fb_batch_desc_init(&batch);
    batch.poses = 1;
    batch.control_floats = model.control_count();
    batch.positions = positions.data();
    batch.position_floats = positions.size();
    if (normals) {
      batch.normals = normals_.emplace_back(positions.size()).data();
      batch.normal_numbers = positions.size();
    }
    items_[f] = {model.get(), nullptr, &batch};
  }
}

void TimedCrowd::set_controls(std::size_t frame, std::span<const float> controls) {
  for (std::size_t f = 0; f < items_.size(); ++f) {
    const std::size_t width = batches_[f].control_floats, poses = controls.size() / width;
    batches_[f].controls = controls.data() + (frame + f) % poses * width;
  }
}

void TimedCrowd::evaluate(std::size_t frame, std::span<const float> controls, std::uint32_t threads) {
  set_controls(frame, controls);
  fb_many_desc desc;
  fb_many_desc_init(&desc);
  desc.threads = threads;
  desc.items = items_.data();
  desc.item_count = static_cast<std::uint32_t>(items_.size());
  scratches_.evaluate(desc);
}

void TimedCrowd::evaluate_in_turn(std::size_t frame, std::span<const float> controls) {
  set_controls(frame, controls);
  for (const fb_many_item& item : items_)
    facebaker::check(fb_evaluate_batch(item.model, scratches_.get().front(), item.batch));
}

}  // namespace fb::tool

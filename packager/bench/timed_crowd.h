// Different faces that are posed together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <span>
#include <vector>

namespace fb::tool {

// Several models of one archive, each loaded by itself, as different characters are, so that they share no memory.
class TimedCrowd {
 public:
  TimedCrowd(const fb_archive_info& archive, std::size_t faces);

  // One pose a face by fb_evaluate_many, face f in pose frame + f of controls (poses x control_count), which begin anew
  // at their end.
  void evaluate(std::size_t frame, std::span<const float> controls, std::uint32_t threads);
  std::size_t size() const { return items_.size(); }

 private:
  struct DestroyScratch {
    void operator()(fb_scratch* scratch) const { fb_scratch_destroy(scratch); }
  };

  std::vector<facebaker::Model> models_;
  std::vector<std::unique_ptr<fb_scratch, DestroyScratch>> scratches_;
  std::vector<std::vector<float>> positions_;
  std::vector<fb_batch_desc> batches_;
  std::vector<fb_many_item> items_;
};

}  // namespace fb::tool

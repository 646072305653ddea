// Different faces that are posed together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <span>
#include <vector>

namespace fb::tool {

// Faces of one archive that are posed together, each with outputs of its own.
class TimedCrowd {
 public:
  // models: how many times the archive is loaded, so that faces share no memory, as different characters do not. Face f
  // is of model f % models. `workers`: threads of evaluate at most.
  TimedCrowd(const fb_archive_info& archive, std::size_t faces, std::size_t models, std::uint32_t workers,
             bool normals = false);

  // One pose a face by fb_evaluate_many, face f in pose frame + f of controls (poses x control_count), which begin anew
  // at their end.
  void evaluate(std::size_t frame, std::span<const float> controls, std::uint32_t threads);
  // The same by one scratch, one after the other; of one model.
  void evaluate_in_turn(std::size_t frame, std::span<const float> controls);
  std::size_t size() const { return items_.size(); }

 private:
  void set_controls(std::size_t frame, std::span<const float> controls);

  std::vector<facebaker::Model> models_;
  facebaker::ScratchPool scratches_;
  std::vector<std::vector<float>> positions_, normals_;
  std::vector<fb_batch_desc> batches_;
  std::vector<fb_many_item> items_;
};

}  // namespace fb::tool

// A component of an engine: many instances of one face, posed once a frame before they are drawn. Built without
// exceptions and RTTI, as engines are.
//
// A frame goes: the game writes controls(i) of the instances that move; update() decides which instances are seen and
// in what detail, and poses those, each group of equal detail as one batch on the engine's job system; the renderer
// reads view(i). After add(), nothing is allocated.
#pragma once

#include <facebaker/facebaker.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host_allocator.h"
#include "job_system.h"

namespace engine {

using Vector = std::array<float, 3>;

struct Bounds {
  Vector low{}, high{};
};

// All in the face's units.
struct Camera {
  Vector position{}, direction{{0, 0, 1}};  // direction: of length 1
  float half_angle = 0.6f;                  // of the cone that is seen, in radians, below a quarter turn
  float full_detail_distance = 100;         // each doubling beyond it is a level of detail less
};

// What the renderer needs of an instance in this frame. Positions are of the object, xyz, in the face's baked order:
// the first `vertices` of fb_vertex_order, which are all that level has. Valid until the next update().
struct FaceView {
  bool visible = false;
  float lod = 0;               // as it was posed: fb_batch_desc::lod
  std::uint32_t level = 0;     // whose polygons to draw: fb_level_at
  std::uint32_t vertices = 0;  // of that level
  const float* positions = nullptr;
  const float* normals = nullptr;
  const float* previous = nullptr;  // the same vertices where they were in the last frame: motion is the difference
  Bounds bounds;                    // of the posed vertices, in the world: for shadows, occlusion and the next frame
};

class FaceSystem {
 public:
  // Null if the face cannot be loaded; `error` then says why. Allocator and job system must outlive the result.
  static std::unique_ptr<FaceSystem> create(const char* path, std::uint32_t capacity, HostAllocator& allocator,
                                            JobSystem& jobs, std::string& error);
  ~FaceSystem();

  // The index of a new instance at rest, which stays at `place`. At most `capacity` instances.
  std::uint32_t add(const Vector& place);
  std::uint32_t size() const { return static_cast<std::uint32_t>(instances_.size()); }
  const fb_model* face() const { return model_; }

  // fb_control_count floats, for the game to write.
  float* controls(std::uint32_t instance) { return controls_.data() + instance * control_count_; }
  // Poses what the camera sees. False if the library refuses, on controls that are not numbers; `error` says which.
  bool update(const Camera& camera, std::string& error);
  const FaceView& view(std::uint32_t instance) const { return instances_[instance].view; }
  // Poses evaluated by the last update().
  std::uint32_t posed() const { return posed_; }

 private:
  struct Instance {
    Vector place{};
    FaceView view;
    Bounds bounds;                          // of the object, when it was last posed
    const float* last_positions = nullptr;  // of the frame before this one
    std::uint32_t last_frame = 0;           // in which it was posed
    std::uint32_t last_steps = 0;           // the detail it had then
  };
  // An instance to pose. Neighbours of equal detail are one batch.
  struct Entry {
    std::uint32_t steps, instance;
  };
  enum class Pose { current, last };

  FaceSystem() = default;
  bool is_seen(const Camera& camera, const Instance& instance) const;
  void choose(const Camera& camera);
  bool pose_all(const std::vector<Entry>& entries, Pose pose, std::string& error);
  bool pose_batch(const Entry* entries, std::size_t first, std::size_t count, Pose pose, std::string& error);

  fb_model* model_ = nullptr;
  fb_scratch* scratch_ = nullptr;
  JobSystem* jobs_ = nullptr;
  std::size_t control_count_ = 0, vertex_count_ = 0;
  std::uint32_t capacity_ = 0, posed_ = 0;
  std::uint32_t frame_ = 1;  // so that no instance was posed in the frame before the first
  float radius_margin_ = 0;
  std::vector<std::uint32_t> level_vertices_;
  Bounds rest_bounds_;
  std::vector<Instance> instances_;
  std::vector<Entry> entries_, unknown_;
  std::vector<float> controls_, last_controls_, batch_controls_, batch_bounds_;
  // A frame's positions one after the other, as they would be uploaded; those of the frame before; and the last poses
  // in the detail of this frame, of instances that had another one or were not seen.
  std::vector<float> positions_, last_positions_, history_, normals_;
};

}  // namespace engine

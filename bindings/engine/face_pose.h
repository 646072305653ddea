/** @file
 * One character in an engine: control values, and its poses as frames that other threads read. What the bindings of
 * Godot and Unreal share; C++17, on the public headers alone.
 */
#ifndef FACEBAKER_ENGINE_FACE_POSE_H
#define FACEBAKER_ENGINE_FACE_POSE_H

#include <facebaker/facebaker.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace facebaker::engine {

/** A pose in the archive's axes and units, as driven joints have moved it, and before joints of the host do, see
 * LinearSkin. Arrays of vertices have room for all, of which the first vertex_count are posed. */
struct PosedFrame {
  std::vector<float> positions;      ///< 3 x vertices, xyz interleaved
  std::vector<float> normals;        ///< 3 x vertices, of unit length
  std::vector<float> tangents;       ///< 3 x vertices, of unit length; empty for a face without texture coordinates
  std::vector<float> sockets;        ///< frames of the face's sockets, 12 floats each
  std::vector<float> driven_joints;  ///< frames of its driven joints, 12 floats each
  std::array<float, 6> bounds{};     ///< smallest x, y and z, then the largest
  std::uint32_t vertex_count = 0;    ///< all in the source's order, or those of the level in baked order
  bool baked = false;                ///< which of both
  std::vector<float> controls;       ///< what it is the pose of
  float lod = 0;                     ///< likewise
  std::uint32_t level = 0;           ///< level of detail whose polygons it is drawn with: lod rounded down
  std::uint64_t number = 0;          ///< 1 for the first pose, and one more for each that differs from the last
};

/** Working memory of poses for the FacePoses of a model: one for each of the threads that pose at the same time,
 * whatever the number of FacePoses. Threads may share it. */
class SharedScratches {
 public:
  /** That of a model, made for the first of its FacePoses and freed with the last. Throws where memory is short. */
  static std::shared_ptr<SharedScratches> of(const Model& model);
  /** Evaluates a batch with a scratch that no other thread uses; see Scratch::evaluate. */
  void evaluate(const fb_batch_desc& batch);
  /** Scratches there are while no thread poses. */
  std::size_t scratch_count();

 private:
  explicit SharedScratches(const Model& model) : model_(model) {}

  Model model_;
  std::mutex mutex_;  // of free_
  std::vector<std::unique_ptr<Scratch>> free_;
};

/** Poses a face. Of one thread at a time; the frames that it gives out never change and may be read by any thread, for
 * as long as it holds them. Frames that nobody holds are used again, so posing allocates nothing once there are as many
 * as readers hold at a time. Any number of FacePoses may share one Model, and its working memory. */
class FacePose {
 public:
  /** At rest. `model` is shared. Throws Error where memory is short. */
  explicit FacePose(const Model& model);

  /** The face. */
  const Model& model() const { return model_; }
  /** Control values, model().control_count() of them. */
  const std::vector<float>& controls() const { return controls_; }
  /** Sets a control; false if there is none at `index`. What is out of its range is clamped when it poses. */
  bool set_control(std::uint32_t index, float value);
  /** Sets all controls; false unless `count` is their number. */
  bool set_controls(const float* values, std::size_t count);
  /** Level of detail, see fb_batch_desc::lod. */
  void set_lod(float lod);
  /** Whether the vertices of the level are posed alone, in baked order, which takes half of the time at coarse levels;
   * all in the source's order at first. */
  void set_level_only(bool level_only);

  /** To be called once a frame. Where something was set since the last call, evaluates a new current frame; the one
   * before becomes the previous one. Otherwise the previous frame becomes the current one, too: nothing moves. Returns
   * whether there is a new frame. Throws Error on NaN, naming the control; frames stay as they are. */
  bool pose();
  /** The last pose; the rest pose before the first call of pose(). */
  std::shared_ptr<const PosedFrame> current() const { return current_; }
  /** Writes the positions of all vertices of the last pose, in the source's order, whatever it has itself. Throws Error
   * where memory is short. */
  void write_positions(std::vector<float>& to) const;
  /** That of the frame before, for motion vectors. */
  std::shared_ptr<const PosedFrame> previous() const { return previous_; }

 private:
  std::shared_ptr<PosedFrame> free_frame();

  Model model_;
  std::shared_ptr<SharedScratches> scratches_;
  std::vector<std::uint32_t> level_vertices_;
  std::vector<float> controls_;
  float lod_ = 0;
  bool level_only_ = false, changed_ = true;
  std::shared_ptr<PosedFrame> current_, previous_;
  std::vector<std::shared_ptr<PosedFrame>> frames_;  // all there are
};

}  // namespace facebaker::engine

#endif

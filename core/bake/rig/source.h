// A source of poses: a live rig, which evaluates any pose, or recorded clips. Training and measuring treat both alike.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "base/status.h"
#include "model/character.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

class EvaluationBackend;

// Same numbers as FB_CLIP_... and FB_SPLIT_... in facebaker_rig.h.
enum class ClipKind : std::int32_t { shot = 0, excitation = 1, regional = 2, calisthenics = 3, dense = 4 };
enum class Split : std::int32_t { train = 0, validation = 1, test = 2 };

const char* name_of(ClipKind kind);              // "shot", ...: the words of dataset.json
const char* name_of(Split split);                // "train", ...
ClipKind clip_kind_from(std::string_view name);  // fails with bad_data, listing the words there are
Split split_from(std::string_view name);

// Controls over consecutive frames.
struct Clip {
  std::string name;
  ClipKind kind = ClipKind::shot;
  Split split = Split::train;
  double fps = 30;
  std::size_t frames = 0;
  std::vector<float> controls;  // frames x controls
};

// Controls of frames [first, first + count) of a clip: count x `width` floats. Fails with invalid_argument unless the
// clip has them.
std::span<const float> frames_of(const Clip& clip, std::size_t first, std::size_t count, std::size_t width);

// Thrown by evaluate for the first pose that cannot be evaluated: its number within the call, and the reason.
class PoseError : public Error {
 public:
  PoseError(Status status, std::size_t pose, std::string reason)
      : Error(status, format("pose %zu: %s", pose, reason.c_str())), pose_(pose), reason_(std::move(reason)) {}
  std::size_t pose() const { return pose_; }
  const std::string& reason() const { return reason_; }

 private:
  std::size_t pose_;
  std::string reason_;
};

// Whether an error is of a pose that a rig cannot evaluate, whatever was added to its message.
inline bool is_of_pose(const Error& error) {
  return error.status() == Status::rig || error.status() == Status::not_finite;
}

class Source {
 public:
  virtual ~Source() = default;

  virtual const RigSchema& schema() const = 0;
  virtual const Mesh& rest() const = 0;
  // Materials and all else that goes into the archive as it is; empty where the source has none.
  virtual const Character& character() const;
  virtual const std::vector<Clip>& clips() const = 0;
  // Frames [first, first + count) of a clip as points: count x 3 x vertices floats, object space, in the schema's
  // units. Recorded ones are read, a live rig's are evaluated. Fails by clip, frame and vertex on what is not finite or
  // too far from rest, see source_rules.h.
  virtual void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) = 0;
  // False for a clip of a dataset that has controls only (a plan): its points cannot be read.
  virtual bool readable(std::size_t) const { return true; }
  // Notes for the user on what was found while opening: values outside their range, clips left out.
  virtual std::vector<std::string> notes() const { return {}; }

  // True if evaluate works: new poses can be evaluated.
  virtual bool live() const { return false; }
  // True if evaluate and read may be called from several threads at once.
  virtual bool thread_safe() const { return false; }
  // Points of new poses (count x controls -> count x 3 x vertices), on the calling thread; see RigEvaluator. Fails with
  // invalid_argument unless live or on a control outside its range, and with PoseError when a pose cannot be evaluated.
  virtual void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points);

  // Poses that a call of evaluate should have, at most most_preferred_poses, for a rig that works on several at once;
  // 0: any number will do.
  virtual std::size_t preferred_block() const { return 0; }
  // A text that changes when the rig's deformation does; "" where the rig declares none.
  virtual std::string version() const { return {}; }
  // A hash of the program that evaluates poses, as far as it is known: of a plugin's file, of a command's text; 0: of
  // nothing. It is no part of dataset.json: a plugin compiled again goes on sampling.
  virtual std::uint64_t program_hash() const { return 0; }
  // Whether `read` gives recorded points of a clip; otherwise it evaluates the clip's controls.
  virtual bool recorded(std::size_t) const { return !live(); }
  // What evaluates blocks of poses for a RigEvaluator: by default a ThreadBackend. This source must outlive it.
  virtual std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel);
};

// "1200 of 2000 poses": how many are in clips that are not readable; "" if none are.
std::string planned_text(const Source& source);

inline constexpr std::size_t most_preferred_poses = 4096;

// What opening a source returns. Clips, schema and mesh are the source's own, so only a source with a name can be asked
// for them: open(...)->clips() does not compile.
class OpenedSource : public std::unique_ptr<Source> {
 public:
  template <class Opened>
  OpenedSource(std::unique_ptr<Opened> source) : std::unique_ptr<Source>(std::move(source)) {}  // NOLINT: implicit
  Source* operator->() const& { return get(); }
  Source* operator->() const&& = delete;
};

}  // namespace fb::bake

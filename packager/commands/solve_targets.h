// Opens what a face is to be solved for, and lays it over the face.
#pragma once

#include <facebaker/facebaker_bake.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "commands/rig_options.h"
#include "export/character_view.h"
#include "options/command.h"
#include "render/image.h"
#include "solve/solve_target.h"

namespace fb::tool {

struct SolveTargetOptions {
  std::string target;
  std::string clip;                    // of a source with several
  std::string units;                   // of the target; "": as it says, or the face's
  std::string up_axis;                 // of the target; "": as it says, or the face's
  std::string placement;               // of markers, a file; "": found
  std::string save_placement;          // "": not saved
  std::string correspondence;          // of another mesh, a file; "": found
  std::string save_correspondence;     // "": not saved
  std::optional<std::size_t> neutral;  // the frame in which nothing has moved; of markers by default the fullest
  double marker_height = 0;            // of the markers' middles over the skin, in millimetres
  RigOptions rigs;

  void add_to(Command command);
};

// A mesh that a target is shown as: its own surface, with the points of a frame as the target has them.
struct TargetSurface {
  std::vector<float> rest;  // in the space of the target
  std::vector<std::uint32_t> polygon_sizes, polygon_corners;
  MeshView view() const { return {rest, polygon_sizes, polygon_corners}; }
};

struct OpenedTarget {
  SolveTarget target;
  bool whole = false;                       // it is the face's own mesh, so that a frame's positions are a pose
  bool moves_head = false;                  // where the head is, is to be found unless somebody says otherwise
  std::optional<TargetSurface> surface;     // of another mesh
  std::optional<Image> fit;                 // how it lies over the face
  std::string fit_text;                     // a paragraph on that; "" for the face's own mesh
  std::optional<facebaker::Source> source;  // that is read from
};

// Markers (.trc, .csv), positions of the face's own vertices (.mdd, .pc2, .npy), or a clip of a source. Fails naming
// file, frame or clip.
OpenedTarget open_target(const SolveTargetOptions& options, const CharacterView& face, const Parallel& parallel);

}  // namespace fb::tool

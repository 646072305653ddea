#include "commands/solve_targets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "base/file_extension.h"
#include "base/length_units.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "solve/correspondence_file.h"
#include "solve/fit_picture.h"
#include "solve/marker_file.h"
#include "solve/marker_placement.h"
#include "solve/mesh_alignment.h"
#include "solve/mesh_correspondence.h"
#include "solve/sampled_surface.h"

namespace fb::tool {
namespace {

constexpr std::size_t surface_samples = 1500;
constexpr std::size_t most_partners = 1500;  // vertices that another mesh is followed by
constexpr double size_range = 1.3;           // by which heads of different people differ

double metres_of(const std::string& unit, const char* option) {
  const auto metres = metres_per(unit);
  if (!metres) fail(Status::invalid_argument, "%s %s: give mm, cm, dm, m, in or ft", option, shown(unit).c_str());
  return *metres;
}

// Units of the face in one of the target; none where either is not known.
std::optional<double> scale_between(const std::optional<double>& target_metres, const CharacterView& face) {
  const auto own = metres_per(face.units);
  if (!own || !target_metres) return std::nullopt;
  return *target_metres / *own;
}

// Turns the target's axes to the face's.
Similarity turned_up(const std::string& target_axis, const std::string& face_axis) {
  Similarity turn;
  if (target_axis.empty() || target_axis == face_axis) return turn;
  if (face_axis == "y")
    turn.rotation = {1, 0, 0, 0, 0, 1, 0, -1, 0};
  else
    turn.rotation = {1, 0, 0, 0, 0, -1, 0, 1, 0};
  return turn;
}

Similarity known_space(const SolveTargetOptions& options, const std::optional<double>& target_metres,
                       const std::string& target_axis, const CharacterView& face) {
  Similarity space = turned_up(options.up_axis.empty() ? target_axis : options.up_axis, face.up_axis);
  std::optional<double> metres = target_metres;
  if (!options.units.empty()) metres = metres_of(options.units, "--target-units");
  space.scale = scale_between(metres, face).value_or(1);
  return space;
}

void check_neutral(const SolveTargetOptions& options, std::size_t frames) {
  if (options.neutral && *options.neutral >= frames)
    fail(Status::invalid_argument, "--neutral %zu: the target has frames 0 to %zu", *options.neutral, frames - 1);
}

// ---- Files of positions ----

OpenedTarget open_points(const SolveTargetOptions& options, const CharacterView& face) {
  std::uint64_t frames = 0, points = 0;
  facebaker::check(fb_point_file_size(options.target.c_str(), &frames, &points));
  if (points != face.mesh.vertex_count())
    fail(Status::bad_data,
         "%s: %llu points, and the face has %zu vertices. Another mesh is solved for as a source with its polygons: a "
         ".glb file or a dataset folder",
         shown(options.target).c_str(), static_cast<unsigned long long>(points), face.mesh.vertex_count());
  OpenedTarget opened;
  opened.whole = true;
  opened.target.frames = frames;
  opened.target.to_face = known_space(options, std::nullopt, "", face);
  opened.target.read = [path = options.target, points](std::size_t frame, std::vector<float>& to) {
    to.resize(3 * points);
    facebaker::check(fb_point_file_read(path.c_str(), frame, 1, to.data(), to.size()));
  };
  return opened;
}

// ---- Sources ----

std::uint32_t find_clip(const facebaker::SourceView& source, const SolveTargetOptions& options) {
  std::string names;
  std::vector<std::uint32_t> readable;
  for (std::uint32_t c = 0; c < source.info().clip_count; ++c) {
    const fb_clip clip = source.clip(c);
    if (!clip.readable) continue;
    if (options.clip == clip.name) return c;
    names += (readable.empty() ? "" : ", ") + shown(std::string(clip.name));
    readable.push_back(c);
  }
  if (readable.empty()) fail(Status::not_found, "%s has no clips", shown(options.target).c_str());
  if (!options.clip.empty())
    fail(Status::not_found, "--clip %s: %s has the clips %s", shown(options.clip).c_str(),
         shown(options.target).c_str(), names.c_str());
  if (readable.size() > 1)
    fail(Status::invalid_argument, "%s has several clips: give one of them with --clip NAME: %s",
         shown(options.target).c_str(), names.c_str());
  return readable[0];
}

bool same_mesh(const fb_source_info& info, const CharacterView& face) {
  const MeshView& mesh = face.mesh;
  return info.vertex_count == mesh.vertex_count() && info.polygon_corner_count == mesh.polygon_corners.size() &&
         std::equal(mesh.polygon_corners.begin(), mesh.polygon_corners.end(), info.polygon_corners);
}

std::vector<Correspondence> partners_of(const SolveTargetOptions& options, const CharacterView& face,
                                        OpenedTarget& opened, const Parallel& parallel) {
  const MeshView other = opened.surface->view();
  const SampledSurface own(face.mesh, surface_samples), target(other, surface_samples);
  AlignmentOptions align;
  align.scale = opened.target.to_face.scale != 1 ? std::optional(opened.target.to_face.scale) : std::nullopt;
  align.scale_range = size_range;
  align.parallel = parallel;
  const Alignment alignment = align_surfaces(target, own, align);
  if (alignment.rival < clear_rival)
    opened.target.notes.push_back(format(
        "the target fits the face turned otherwise nearly as well (%.2f times as far): look at the picture of the "
        "fit",
        alignment.rival));
  opened.target.to_face = alignment.to_face;
  CorrespondenceOptions find;
  find.parallel = parallel;
  MeshCorrespondence found = find_correspondence(own, target, alignment.to_face, find);
  if (!options.correspondence.empty()) {
    found.vertices = read_correspondence(options.correspondence, face.mesh.vertex_count(), other.vertex_count());
    found.statistics = statistics_of(found.vertices);
  }
  if (!options.save_correspondence.empty()) write_correspondence(options.save_correspondence, found.vertices);
  opened.fit = draw_mesh_fit(face.mesh, other, alignment.to_face, found,
                             {.up_axis = face.up_axis, .unit = face.units, .parallel = parallel});
  opened.fit_text = correspondence_text(found, face.units);
  return found.vertices;
}

// Every so many of the vertices that have a partner.
void follow_partners(std::vector<Correspondence> partners, std::span<const float> rest, OpenedTarget& opened) {
  std::erase_if(partners, [](const Correspondence& one) { return one.partner != Partner::found; });
  if (partners.empty()) fail(Status::bad_data, "no vertex of the face has a partner on the target");
  const std::size_t step = (partners.size() + most_partners - 1) / most_partners;
  SolveTarget& target = opened.target;
  for (std::size_t i = 0; i < partners.size(); i += step) {
    const Correspondence& one = partners[i];
    target.face_points.push_back({{one.vertex, one.vertex, one.vertex}, {1, 0, 0}});
    target.target_points.push_back(one.other);
    const Vector3 at = target.to_face(one.other.at(opened.surface->rest));
    for (std::size_t a = 0; a < 3; ++a)
      target.offsets.push_back((a == 0 ? at.x : a == 1 ? at.y : at.z) - rest[3 * std::size_t(one.vertex) + a]);
  }
}

OpenedTarget open_source_clip(const SolveTargetOptions& options, const CharacterView& face, const Parallel& parallel) {
  OpenedTarget opened;
  opened.source = options.rigs.open({options.target}, opened.target.notes);
  const facebaker::SourceView source(*opened.source);
  const fb_source_info& info = source.info();
  const std::uint32_t clip = find_clip(source, options);
  SolveTarget& target = opened.target;
  target.frames = source.clip(clip).frames;
  target.fps = source.clip(clip).fps;
  target.to_face = known_space(options, metres_per(info.units), info.up_axis, face);
  target.read = [handle = source.get(), clip, floats = 3 * std::size_t(info.vertex_count)](std::size_t frame,
                                                                                           std::vector<float>& to) {
    to.resize(floats);
    facebaker::check(fb_source_read(handle, clip, frame, 1, to.data(), to.size()));
  };
  opened.whole = same_mesh(info, face) && options.correspondence.empty();
  if (opened.whole) return opened;
  opened.surface = {{info.rest_positions, info.rest_positions + 3 * std::size_t(info.vertex_count)},
                    {info.polygon_sizes, info.polygon_sizes + info.polygon_count},
                    {info.polygon_corners, info.polygon_corners + info.polygon_corner_count}};
  follow_partners(partners_of(options, face, opened, parallel), face.mesh.points, opened);
  return opened;
}

// ---- Markers ----

// From where markers were seen in the neutral frame to where they are placed, of another size where that is likely.
Similarity space_of_placement(const MarkerTake& take, std::size_t neutral, const MarkerPlacement& placement,
                              std::span<const float> rest, double scale) {
  std::vector<PointPair> pairs;
  for (const PlacedMarker& marker : placement.markers) {
    const auto name = std::find(take.names.begin(), take.names.end(), marker.name);
    if (name == take.names.end()) continue;
    const auto index = static_cast<std::size_t>(name - take.names.begin());
    if (take.missing_of(neutral)[index]) continue;
    const float* const at = take.positions_of(neutral).data() + 3 * index;
    pairs.push_back({{at[0], at[1], at[2]}, marker.point.at(rest)});
  }
  const auto free = align_pairs(pairs, std::nullopt);
  if (free && free->scale < size_range * scale && free->scale * size_range > scale) return *free;
  const auto fixed = align_pairs(pairs, scale);
  if (!fixed)
    fail(Status::bad_data, "frame %zu has %zu of the placed markers, too few to tell where the head is", neutral,
         pairs.size());
  return *fixed;
}

void follow_markers(const std::shared_ptr<const MarkerTake>& take, const MarkerPlacement& placement,
                    SolveTarget& target) {
  std::vector<std::uint32_t> columns;
  std::string unknown;
  for (const PlacedMarker& marker : placement.markers) {
    const auto name = std::find(take->names.begin(), take->names.end(), marker.name);
    if (name == take->names.end()) {
      unknown += (unknown.empty() ? "" : ", ") + shown(marker.name);
      continue;
    }
    const auto column = static_cast<std::uint32_t>(columns.size());
    columns.push_back(static_cast<std::uint32_t>(name - take->names.begin()));
    target.face_points.push_back(marker.point);
    target.target_points.push_back({{column, column, column}, {1, 0, 0}});
  }
  if (!unknown.empty()) target.notes.push_back("placed, but not captured: " + unknown);
  if (columns.empty()) fail(Status::bad_data, "no marker of the take is placed on the face");
  target.read = [take, columns](std::size_t frame, std::vector<float>& to) {
    to.clear();
    for (const std::uint32_t column : columns)
      for (std::size_t a = 0; a < 3; ++a)
        to.push_back(take->missing_of(frame)[column] ? std::numeric_limits<float>::quiet_NaN()
                                                     : take->positions_of(frame)[3 * column + a]);
  };
}

OpenedTarget open_markers(const SolveTargetOptions& options, const CharacterView& face, const Parallel& parallel) {
  const auto take = std::make_shared<const MarkerTake>(read_marker_file(options.target));
  OpenedTarget opened;
  SolveTarget& target = opened.target;
  target.frames = take->frames;
  target.fps = take->frames_per_second > 0 ? take->frames_per_second : 30;
  target.notes = take->notes;
  check_neutral(options, take->frames);
  const std::size_t neutral = options.neutral.value_or(fullest_frame(*take));
  const std::vector<Vector3> seen = seen_markers(*take, neutral);
  const double metres = !options.units.empty()  ? metres_of(options.units, "--target-units")
                        : take->metres_per_unit ? *take->metres_per_unit
                                                : likely_metres_per_unit(seen);
  const auto own = metres_per(face.units);
  const double scale = scale_between(metres, face).value_or(1), millimetre = own ? 0.001 / *own : 1;
  const SampledSurface surface(face.mesh, surface_samples);
  MarkerPlacement placement;
  if (!options.placement.empty()) {
    placement = read_marker_placement(options.placement, face.mesh.vertex_count());
    target.to_face = space_of_placement(*take, neutral, placement, face.mesh.points, scale);
  } else {
    AlignmentOptions align;
    align.scale = scale;
    align.scale_range = size_range;
    align.parallel = parallel;
    const Alignment alignment = align_points(seen, surface, face.up_axis, options.marker_height * millimetre, align);
    if (alignment.rival < clear_rival)
      target.notes.push_back(
          format("the markers fit the face turned otherwise nearly as well (%.2f times as far): look "
                 "at the picture of the fit",
                 alignment.rival));
    target.to_face = alignment.to_face;
    placement = place_markers(*take, neutral, alignment.to_face, surface, 0.1 * surface.diagonal, face.units);
    target.notes.insert(target.notes.end(), placement.notes.begin(), placement.notes.end());
  }
  if (!options.save_placement.empty()) write_marker_placement(options.save_placement, placement, face.units);
  follow_markers(take, placement, target);
  target.set_offsets(neutral, face.mesh.points);
  opened.moves_head = true;
  opened.fit =
      draw_marker_fit(face.mesh, placement, {.up_axis = face.up_axis, .unit = face.units, .parallel = parallel});
  opened.fit_text = format(
      "%zu of %zu markers are followed, as they move from frame %zu, in which the face is taken to "
      "be at rest.",
      target.face_points.size(), take->markers(), neutral);
  return opened;
}

}  // namespace

void SolveTargetOptions::add_to(Command command) {
  command
      .add_option("TARGET", target,
                  "Captured markers (.trc, .csv); positions of the face's own vertices (.mdd, .pc2, .npy of frames x "
                  "vertices x 3); or a clip of a dataset folder, a rig or a .glb, of the face's mesh or another one")
      .required();
  command.add_option("--clip", clip, "Which clip of a source that has several").type_name("NAME");
  command
      .add_option("--target-units", units,
                  "Unit of the target's lengths, where its file does not say or says it wrongly: mm, cm, dm, m, in, ft")
      .type_name("UNIT");
  command.add_option("--target-up", up_axis, "The target's axis that points up; by default as it says, or the face's")
      .one_of({"y", "z"});
  command
      .add_option("--neutral", neutral,
                  "The frame in which the face is at rest: points count as how far they have moved since. By default, "
                  "of markers, the first in which most are seen; other targets count as where they are")
      .type_name("FRAME")
      .checked(whole_number);
  command
      .add_option(
          "--placement", placement,
          "Where markers sit on the face, a JSON file (docs/solve-targets.md); by default found from the neutral "
          "frame")
      .type_name("FILE");
  command.add_option("--save-placement", save_placement, "Write where markers sit, to be corrected and given again")
      .type_name("FILE");
  command
      .add_option("--marker-height", marker_height,
                  "How far middles of markers are over the skin, in millimetres: half a marker's size")
      .shows_default()
      .not_negative();
  command
      .add_option(
          "--correspondence", correspondence,
          "Which points of another mesh are which of the face, a JSON or NumPy file; by default the closest ones")
      .type_name("FILE");
  command.add_option("--save-correspondence", save_correspondence, "Write them").type_name("FILE");
  rigs.add_to(command);
}

OpenedTarget open_target(const SolveTargetOptions& options, const CharacterView& face, const Parallel& parallel) {
  const std::string form = file_extension(options.target);
  const bool markers = form == ".trc" || form == ".csv", points = form == ".mdd" || form == ".pc2" || form == ".npy";
  OpenedTarget opened = markers  ? open_markers(options, face, parallel)
                        : points ? open_points(options, face)
                                 : open_source_clip(options, face, parallel);
  opened.target.what = shown(options.target);
  check_neutral(options, opened.target.frames);
  if (options.neutral && !markers) opened.target.set_offsets(*options.neutral, face.mesh.points);
  return opened;
}

}  // namespace fb::tool

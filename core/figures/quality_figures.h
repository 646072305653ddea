// Visible errors besides distances: shading (normals), jitter, seams, contact; and errors by region, control and
// vertex.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "figures/member_list.h"

namespace fb {

// Over D, the rest mesh's bounding-box diagonal: a pixel where the face is a thousand pixels tall. Places nearer than
// this touch, and a gap that differs by more than this is seen.
constexpr double visible_gap = 1e-3;

// Errors of gaps over D, with e the error vectors of places, predicted - true: the gap of a touching pair is off by
// (e(p) - e(q)) . direction, which is positive where the face parts what touches, and negative where it moves one place
// into the other.
struct ContactErrors {
  std::size_t looked_at = 0;          // frames that were searched
  std::size_t frames = 0, pairs = 0;  // those in which something touches; touching pairs in all of them
  double rms = 0, max = 0;            // of pairs; max: the largest absolute error
  double visible = visible_gap;       // what is seen
  std::size_t open = 0, deep = 0;     // pairs with an error above `visible`, and below -`visible`
  // Of the vertices of the frames that were searched, those that touch something, and of the squared error there,
  // theirs.
  double vertex_share = 0, error_share = 0;
  // Where the largest absolute error is; the clip and the name of the place (FaceMap::name_of) in an EvalReport alone.
  std::string worst_clip = {}, worst_place = {};
  std::size_t worst_frame = 0;  // of worst_clip; without it, of all frames
  std::uint32_t worst_vertex = 0;
  double worst = 0;  // that error
};

template <class Visit, MaybeConst<ContactErrors> Struct>
void visit_fields(Visit& visit, Struct& contact) {
  visit("looked_at", contact.looked_at);
  visit("frames", contact.frames);
  visit("pairs", contact.pairs);
  visit("rms", contact.rms);
  visit("max", contact.max);
  visit("visible", contact.visible);
  visit("open", contact.open);
  visit("deep", contact.deep);
  visit("vertex_share", contact.vertex_share);
  visit("error_share", contact.error_share);
  visit.object_if("worst", contact.pairs > 0, [&](auto& worst) {
    worst("clip", contact.worst_clip);
    worst("frame", contact.worst_frame);
    worst("vertex", contact.worst_vertex);
    worst("place", contact.worst_place);
    worst("error", contact.worst);
  });
}

// Errors of a region of the model, over D^2 and D.
struct RegionErrors {
  std::string name, title;          // title: by place and what moves it, see describe
  std::vector<std::string> movers;  // controls
  std::size_t vertices = 0;
  double mse = 0, max = 0;
  double mfm = 0, p99fm = 0;  // mean and 99th percentile of the frames' worst vertices, see Errors
};

template <class Visit, MaybeConst<RegionErrors> Struct>
void visit_fields(Visit& visit, Struct& region) {
  visit("name", region.name);
  visit("title", region.title);
  visit("movers", region.movers);
  visit("vertices", region.vertices);
  visit("mse", region.mse);
  visit("max", region.max);
  visit("mfm", region.mfm);
  visit("p99fm", region.p99fm);
}

// Errors over some frames, over D^2 and D.
struct FrameSetErrors {
  std::size_t frames = 0;
  double mse = 0, max = 0;
};

template <class Visit, MaybeConst<FrameSetErrors> Struct>
void visit_fields(Visit& visit, Struct& errors) {
  visit("frames", errors.frames);
  visit("mse", errors.mse);
  visit("max", errors.max);
}

// Errors of the frames in which a control is beyond half its reach: of the whole face, and, where others are off rest
// too, of what the control moves.
struct ControlQuality {
  std::string name;
  FrameSetErrors all;
  std::size_t vertices = 0;  // that the control alone moves, see FaceMap; all, if it alone moves none
  FrameSetErrors combined;   // of those vertices, in the frames in which another control is off rest
};

template <class Visit, MaybeConst<ControlQuality> Struct>
void visit_fields(Visit& visit, Struct& control) {
  visit("name", control.name);
  visit_fields(visit, control.all);
  visit("vertices", control.vertices);
  visit("combined", control.combined);
}

// With e the error vector of a vertex, predicted - true, over D, the rest mesh's bounding-box diagonal.
struct Quality {
  // Degrees between area-weighted vertex normals, over vertices with a polygon that has an area.
  double normal_rms = 0, normal_p99 = 0;
  // Root mean square of |e(t-1) - 2 e(t) + e(t+1)| over consecutive frames of shots of 3 frames or more; jitter_frames
  // is 0 without any.
  double jitter = 0;
  std::size_t jitter_frames = 0;
  // Root mean square of |e(i) - e(j)| over edges i-j of polygons: of edges between parts, and of edges inside a part.
  // The latter are weighted so that each border edge counts the edges inside the two parts it joins equally: a seam is
  // a border_jump above inside_jump. Without border edges inside_jump is over all edges inside parts.
  double border_jump = 0, inside_jump = 0;
  std::size_t border_edges = 0;
  ContactErrors contact;                 // of every contact_step-th frame
  std::vector<RegionErrors> regions;     // parts of the face that have vertices
  std::vector<ControlQuality> controls;  // those that are beyond half their reach in some frame
  std::vector<float> vertex_rms;         // one a vertex
  std::vector<std::uint32_t>
      vertex_region;                      // one a vertex: an index into region_names; their number where none moves it
  std::vector<std::string> region_names;  // of the model's regions, also of those without vertices
};

template <class Visit, MaybeConst<Quality> Struct>
void visit_fields(Visit& visit, Struct& quality) {
  visit("normal_degrees_rms", quality.normal_rms);
  visit("normal_degrees_p99", quality.normal_p99);
  visit("jitter", quality.jitter);
  visit("jitter_frames", quality.jitter_frames);
  visit("border_jump", quality.border_jump);
  visit("inside_jump", quality.inside_jump);
  visit("border_edges", quality.border_edges);
  visit("contact", quality.contact);
  visit("regions", quality.regions);
  visit("controls", quality.controls);
  if (!visit.details()) return;
  visit("vertex_rms", quality.vertex_rms);
  visit("vertex_region", quality.vertex_region);
  visit("region_names", quality.region_names);
}

}  // namespace fb

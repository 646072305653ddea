#include "bake/measure/quality.h"

#include <algorithm>
#include <cmath>

#include "bake/regions/surface_graph.h"
#include "base/surface.h"

namespace fb::bake {
namespace {

// Of a control's reach: from where its frames are counted, and from where it is off rest.
constexpr float active_share = 0.5f, off_rest_share = 0.01f;

// predicted - truth, over D.
std::vector<float> error_of(std::span<const float> predicted, std::span<const float> truth, double diagonal) {
  std::vector<float> error(truth.size());
  for (std::size_t i = 0; i < error.size(); ++i)
    error[i] = static_cast<float>((double(predicted[i]) - truth[i]) / diagonal);
  return error;
}

double square(Vector3 v) {
  return double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z;
}

double mean(double sum, double count) {
  return count > 0 ? sum / count : 0;
}

}  // namespace

QualityBasis::QualityBasis(const Mesh& rest, const RigSchema& rig, FaceParts of_face,
                           std::vector<std::vector<std::uint32_t>> moved_by)
    : schema(rig),
      diagonal(rest.diagonal()),
      parts(std::move(of_face)),
      moved(std::move(moved_by)),
      triangles(rest.triangles()),
      contact(rest) {
  moved.resize(schema.control_count());
  const SurfaceGraph graph(rest, {});
  for (std::uint32_t v = 0; v < graph.size(); ++v)
    for (const SurfaceGraph::Edge& edge : graph.edges(v)) {
      if (edge.vertex < v) continue;
      const std::uint32_t a = parts.labels[v], b = parts.labels[edge.vertex];
      if (a >= parts.names.size() || b >= parts.names.size()) continue;
      (a != b ? borders : insides).push_back({v, edge.vertex});
    }
  std::vector<double> inside(parts.names.size()), beside(parts.names.size());
  for (const auto& [a, b] : insides) ++inside[parts.labels[a]];
  for (const auto& [a, b] : borders) {
    beside[parts.labels[a]] += 0.5;
    beside[parts.labels[b]] += 0.5;
  }
  const double all = static_cast<double>(borders.empty() ? insides.size() : borders.size());
  for (std::size_t p = 0; p < inside.size(); ++p)
    inside_weights.push_back(inside[p] == 0 ? 0 : (borders.empty() ? 1 : beside[p] / inside[p]) / all);
}

void QualitySums::add_warm_up(std::span<const float> predicted, std::span<const float> truth) {
  add_jitter(error_of(predicted, truth, basis_->diagonal), false);
}

void QualitySums::add_frame(std::span<const float> controls, std::span<const float> predicted,
                            std::span<const float> truth, bool shot, bool contact) {
  std::vector<float> error = error_of(predicted, truth, basis_->diagonal);
  frames_.push_back(add_vertices(error));
  add_controls(controls, frames_.back());
  add_jumps(error);
  const std::vector<Vector3> normals = vertex_normals(basis_->triangles, truth);
  add_normals(vertex_normals(basis_->triangles, predicted), normals);
  if (contact) contact_.add_frame(frames_.size() - 1, basis_->contact.touching(truth, normals), error);
  if (shot) add_jitter(std::move(error), true);
}

FrameErrors QualitySums::add_vertices(const std::vector<float>& error) {
  const std::size_t vertices = error.size() / 3;
  vertex_squares_.resize(vertices);
  vertex_worst_.resize(vertices);
  squares_.resize(vertices);
  std::vector<double> region_worst(basis_->parts.names.size() + 1);
  double squares = 0, worst = 0;
  std::uint32_t worst_vertex = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    const double squared = square(vector_at(error.data(), v));
    vertex_squares_[v] += squared;
    vertex_worst_[v] = std::max(vertex_worst_[v], static_cast<float>(squared));
    squares_[v] = static_cast<float>(squared);
    squares += squared;
    double& of_region = region_worst[basis_->parts.labels[v]];
    of_region = std::max(of_region, squared);
    if (squared <= worst) continue;
    worst = squared;
    worst_vertex = static_cast<std::uint32_t>(v);
  }
  region_maxima_.resize(region_worst.size());
  for (std::size_t r = 0; r < region_worst.size(); ++r) region_maxima_[r].add(region_worst[r]);
  return {static_cast<float>(mean(squares, static_cast<double>(vertices))), static_cast<float>(std::sqrt(worst)),
          worst_vertex};
}

// Of the vertices that a control moves.
FrameErrors QualitySums::errors_where_moved(std::size_t control, const FrameErrors& frame) const {
  const std::vector<std::uint32_t>& vertices = basis_->moved[control];
  if (vertices.empty()) return frame;
  double sum = 0;
  float worst = 0;
  for (const std::uint32_t v : vertices) {
    sum += squares_[v];
    worst = std::max(worst, squares_[v]);
  }
  return {static_cast<float>(sum / static_cast<double>(vertices.size())), std::sqrt(worst)};
}

void QualitySums::Part::add(double mse, double max) {
  ++frames;
  squares += mse;
  worst = std::max(worst, max);
}

void QualitySums::Part::append(const Part& later) {
  frames += later.frames;
  squares += later.squares;
  worst = std::max(worst, later.worst);
}

FrameSetErrors QualitySums::Part::errors() const {
  return {frames, mean(squares, static_cast<double>(frames)), worst};
}

void QualitySums::add_controls(std::span<const float> controls, const FrameErrors& frame) {
  controls_.resize(controls.size());
  const auto beyond = [&](std::size_t c, float share) {
    const Control& control = basis_->schema.controls[c];
    return std::abs(controls[c] - control.rest) > share * control.reach();
  };
  std::size_t off_rest = 0;
  for (std::size_t c = 0; c < controls.size(); ++c) off_rest += beyond(c, off_rest_share);
  for (std::size_t c = 0; c < controls.size(); ++c) {
    if (!beyond(c, active_share)) continue;
    controls_[c].all.add(frame.mse, frame.max);
    if (off_rest < 2) continue;
    const FrameErrors moved = errors_where_moved(c, frame);
    controls_[c].combined.add(moved.mse, moved.max);
  }
}

void QualitySums::add_jumps(const std::vector<float>& error) {
  const auto jump = [&](const auto& edge) {
    return square(vector_at(error.data(), edge[0]) - vector_at(error.data(), edge[1]));
  };
  for (const auto& edge : basis_->borders) border_squares_ += jump(edge);
  for (const auto& edge : basis_->insides)
    inside_squares_ += basis_->inside_weights[basis_->parts.labels[edge[0]]] * jump(edge);
}

void QualitySums::add_normals(const std::vector<Vector3>& predicted, const std::vector<Vector3>& truth) {
  for (std::size_t v = 0; v < truth.size(); ++v) {
    if (square(predicted[v]) == 0 || square(truth[v]) == 0) continue;
    const double angle = degrees_between(predicted[v], truth[v]);
    normal_squares_ += angle * angle;
    angles_.add(static_cast<float>(angle));
    ++normals_;
  }
}

void QualitySums::add_jitter(std::vector<float> error, bool count) {
  if (count && past_.size() == 2) {
    for (std::size_t i = 0; i < error.size(); ++i) {
      const double second = double(past_[0][i]) - 2.0 * past_[1][i] + error[i];
      jitter_squares_ += second * second;
    }
    ++jitter_frames_;
  }
  if (past_.size() == 2) past_.erase(past_.begin());
  past_.push_back(std::move(error));
}

void QualitySums::append(const QualitySums& later) {
  if (later.frames_.empty()) return;
  jitter_frames_ += later.jitter_frames_;
  normals_ += later.normals_;
  border_squares_ += later.border_squares_;
  inside_squares_ += later.inside_squares_;
  normal_squares_ += later.normal_squares_;
  jitter_squares_ += later.jitter_squares_;
  angles_.append(later.angles_);
  contact_.append(later.contact_, frames_.size());
  frames_.insert(frames_.end(), later.frames_.begin(), later.frames_.end());
  vertex_squares_.resize(later.vertex_squares_.size());
  vertex_worst_.resize(later.vertex_worst_.size());
  for (std::size_t v = 0; v < vertex_squares_.size(); ++v) {
    vertex_squares_[v] += later.vertex_squares_[v];
    vertex_worst_[v] = std::max(vertex_worst_[v], later.vertex_worst_[v]);
  }
  region_maxima_.resize(later.region_maxima_.size());
  for (std::size_t r = 0; r < region_maxima_.size(); ++r) region_maxima_[r].append(later.region_maxima_[r]);
  controls_.resize(later.controls_.size());
  for (std::size_t c = 0; c < controls_.size(); ++c) {
    controls_[c].all.append(later.controls_[c].all);
    controls_[c].combined.append(later.controls_[c].combined);
  }
}

Quality QualitySums::figures() const {
  Quality quality;
  const auto frames = static_cast<double>(frames_.size());
  const auto root_mean = [&](double squares, std::size_t count) {
    return std::sqrt(mean(squares, static_cast<double>(count)));
  };
  quality.normal_rms = root_mean(normal_squares_, normals_);
  quality.normal_p99 = angles_.p99();
  quality.jitter = root_mean(jitter_squares_, jitter_frames_ * vertex_squares_.size());
  quality.jitter_frames = jitter_frames_;
  quality.border_jump = root_mean(border_squares_, basis_->borders.size() * frames_.size());
  quality.inside_jump = root_mean(inside_squares_, frames_.size());
  quality.border_edges = basis_->borders.size();
  quality.contact = contact_.figures();
  quality.region_names = basis_->parts.names;
  quality.vertex_region = basis_->parts.labels;
  for (std::size_t c = 0; c < controls_.size(); ++c) {
    const std::string& name = basis_->schema.controls[c].name;
    const std::size_t moved = basis_->moved[c].size();
    if (controls_[c].all.frames > 0)
      quality.controls.push_back({name, controls_[c].all.errors(), moved > 0 ? moved : vertex_squares_.size(),
                                  controls_[c].combined.errors()});
  }
  const FaceParts& parts = basis_->parts;
  std::vector<RegionErrors> regions;
  for (std::size_t r = 0; r < parts.names.size(); ++r)
    regions.push_back(parts.titles.empty() ? RegionErrors{parts.names[r], {}, {}}
                                           : RegionErrors{parts.names[r], parts.titles[r], parts.movers[r]});
  for (std::size_t v = 0; v < vertex_squares_.size(); ++v) {
    const double mse = mean(vertex_squares_[v], frames);
    quality.vertex_rms.push_back(static_cast<float>(std::sqrt(mse)));
    const std::uint32_t label = parts.labels[v];
    if (label == regions.size()) continue;
    ++regions[label].vertices;
    regions[label].mse += mse;
    regions[label].max = std::max(regions[label].max, std::sqrt(double(vertex_worst_[v])));
  }
  for (std::size_t r = 0; r < regions.size(); ++r) {
    RegionErrors& region = regions[r];
    if (region.vertices == 0) continue;
    region.mse /= static_cast<double>(region.vertices);
    region.mfm = region_maxima_[r].mean();
    region.p99fm = std::min(region_maxima_[r].p99(), region.max);
    quality.regions.push_back(region);
  }
  return quality;
}

}  // namespace fb::bake

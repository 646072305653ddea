#include "bake/measure/quality.h"

#include <algorithm>
#include <cmath>

#include "bake/regions/surface_graph.h"
#include "base/surface.h"

namespace fb::bake {
namespace {

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

double degrees_between(Vector3 a, Vector3 b) {
  constexpr double per_radian = 57.29577951308232;
  return std::atan2(double(length(cross(a, b))), double(dot(a, b))) * per_radian;
}

double mean(double sum, double count) {
  return count > 0 ? sum / count : 0;
}

}  // namespace

QualityBasis::QualityBasis(const Mesh& rest, const RigSchema& rig, FaceParts of_face)
    : schema(rig), diagonal(rest.diagonal()), parts(std::move(of_face)), triangles(rest.triangles()) {
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
                            std::span<const float> truth, bool shot) {
  std::vector<float> error = error_of(predicted, truth, basis_->diagonal);
  frames_.push_back(add_vertices(error));
  add_controls(controls, frames_.back());
  add_jumps(error);
  add_normals(predicted, truth);
  if (shot) add_jitter(std::move(error), true);
}

FrameErrors QualitySums::add_vertices(const std::vector<float>& error) {
  const std::size_t vertices = error.size() / 3;
  vertex_squares_.resize(vertices);
  vertex_worst_.resize(vertices);
  double squares = 0, worst = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    const double squared = square(vector_at(error.data(), v));
    vertex_squares_[v] += squared;
    vertex_worst_[v] = std::max(vertex_worst_[v], static_cast<float>(squared));
    squares += squared;
    worst = std::max(worst, squared);
  }
  return {static_cast<float>(mean(squares, static_cast<double>(vertices))), static_cast<float>(std::sqrt(worst))};
}

void QualitySums::add_controls(std::span<const float> controls, const FrameErrors& frame) {
  controls_.resize(controls.size());
  for (std::size_t c = 0; c < controls.size(); ++c) {
    const Control& control = basis_->schema.controls[c];
    if (std::abs(controls[c] - control.rest) <= 0.5f * control.reach()) continue;
    ++controls_[c].frames;
    controls_[c].squares += frame.mse;
    controls_[c].worst = std::max<double>(controls_[c].worst, frame.max);
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

void QualitySums::add_normals(std::span<const float> predicted, std::span<const float> truth) {
  const std::vector<Vector3> ours = vertex_normals(basis_->triangles, predicted);
  const std::vector<Vector3> theirs = vertex_normals(basis_->triangles, truth);
  for (std::size_t v = 0; v < ours.size(); ++v) {
    if (square(ours[v]) == 0 || square(theirs[v]) == 0) continue;
    const double angle = degrees_between(ours[v], theirs[v]);
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
  frames_.insert(frames_.end(), later.frames_.begin(), later.frames_.end());
  vertex_squares_.resize(later.vertex_squares_.size());
  vertex_worst_.resize(later.vertex_worst_.size());
  for (std::size_t v = 0; v < vertex_squares_.size(); ++v) {
    vertex_squares_[v] += later.vertex_squares_[v];
    vertex_worst_[v] = std::max(vertex_worst_[v], later.vertex_worst_[v]);
  }
  controls_.resize(later.controls_.size());
  for (std::size_t c = 0; c < controls_.size(); ++c) {
    controls_[c].frames += later.controls_[c].frames;
    controls_[c].squares += later.controls_[c].squares;
    controls_[c].worst = std::max(controls_[c].worst, later.controls_[c].worst);
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
  quality.parts = basis_->parts;
  for (std::size_t c = 0; c < controls_.size(); ++c)
    if (const Part& part = controls_[c]; part.frames > 0)
      quality.controls.push_back(
          {basis_->schema.controls[c].name, part.frames, part.squares / static_cast<double>(part.frames), part.worst});
  std::vector<PartErrors> regions;
  for (const std::string& name : basis_->parts.names) regions.push_back({name});
  for (std::size_t v = 0; v < vertex_squares_.size(); ++v) {
    const double mse = mean(vertex_squares_[v], frames);
    quality.vertex_rms.push_back(static_cast<float>(std::sqrt(mse)));
    const std::uint32_t label = basis_->parts.labels[v];
    if (label == regions.size()) continue;
    ++regions[label].count;
    regions[label].mse += mse;
    regions[label].max = std::max(regions[label].max, std::sqrt(double(vertex_worst_[v])));
  }
  for (PartErrors& region : regions) {
    if (region.count == 0) continue;
    region.mse /= static_cast<double>(region.count);
    quality.regions.push_back(region);
  }
  return quality;
}

}  // namespace fb::bake

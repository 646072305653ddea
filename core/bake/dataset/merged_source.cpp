#include "bake/dataset/merged_source.h"

#include <algorithm>
#include <cmath>

#include "bake/rig/evaluation_backend.h"

namespace fb::bake {
namespace {

void check_same_rest(const Mesh& a, const char* a_name, const Mesh& b, const char* b_name) {
  if (a.vertex_count() != b.vertex_count())
    fail(Status::bad_data, "%s has %zu vertices, %s has %zu", a_name, a.vertex_count(), b_name, b.vertex_count());
  if (a.polygon_sizes != b.polygon_sizes || a.polygon_corners != b.polygon_corners)
    fail(Status::bad_data, "%s and %s have different polygons", a_name, b_name);
  if (a.uvs != b.uvs || a.uv_corners != b.uv_corners)
    fail(Status::bad_data, "%s and %s have different texture coordinates", a_name, b_name);
  if (!a.parts.empty() && !b.parts.empty() && a.parts != b.parts)
    fail(Status::bad_data, "%s and %s have different meshes or materials of them", a_name, b_name);
  const double tolerance = 1e-5 * a.diagonal();
  for (std::size_t i = 0; i < a.points.size(); ++i)
    if (std::abs(double(a.points[i]) - b.points[i]) > tolerance)
      fail(Status::bad_data, "%s and %s have different rest meshes: vertex %zu is elsewhere", a_name, b_name, i / 3);
}

}  // namespace

MergedSource::MergedSource(std::vector<std::unique_ptr<Source>> sources, const std::vector<std::string>& names)
    : sources_(std::move(sources)) {
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    check_same_controls(schema(), names[0].c_str(), sources_[i]->schema(), names[i].c_str());
    check_same_channels(schema(), names[0].c_str(), sources_[i]->schema(), names[i].c_str());
    check_same_rest(rest(), names[0].c_str(), sources_[i]->rest(), names[i].c_str());
    if (!(rest().driven == sources_[i]->rest().driven))
      fail(Status::bad_data, "%s and %s have different driven joints", names[0].c_str(), names[i].c_str());
    if (!live_ && sources_[i]->live()) live_ = sources_[i].get();
    for (const std::string& note : sources_[i]->notes()) notes_.push_back(names[i] + ": " + note);
    add_clips(*sources_[i], names[i]);
  }
}

void MergedSource::add_clips(Source& source, const std::string& name) {
  const auto named = [this](const std::string& clip_name) {
    return std::find_if(clips_.begin(), clips_.end(), [&](const Clip& c) { return c.name == clip_name; });
  };
  for (std::size_t i = 0; i < source.clips().size(); ++i) {
    Clip clip = source.clips()[i];
    const auto same =
        std::find_if(clips_.begin(), clips_.end(), [&](const Clip& c) { return c.controls == clip.controls; });
    if (same != clips_.end()) {
      if (same->split != clip.split)
        fail(Status::bad_data, "%s: clip \"%s\" is of split %s, but the same clip \"%s\" is of split %s elsewhere",
             name.c_str(), clip.name.c_str(), name_of(clip.split), same->name.c_str(), name_of(same->split));
      Origin& origin = origins_[static_cast<std::size_t>(same - clips_.begin())];
      if (!origin.source->readable(origin.clip)) origin = {&source, i};
      notes_.push_back(format("%s: clip \"%s\" is there already and left out", name.c_str(), clip.name.c_str()));
      continue;
    }
    if (named(clip.name) != clips_.end()) {
      std::string other;
      for (int number = 2; named(other = format("%s (%d)", clip.name.c_str(), number)) != clips_.end();) ++number;
      notes_.push_back(format("%s: its clip \"%s\" is called \"%s\"", name.c_str(), clip.name.c_str(), other.c_str()));
      clip.name = other;
    }
    clips_.push_back(std::move(clip));
    origins_.push_back({&source, i});
  }
}

void MergedSource::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  origins_.at(clip).source->read(origins_[clip].clip, first, count, points);
}

bool MergedSource::readable(std::size_t clip) const {
  return origins_.at(clip).source->readable(origins_[clip].clip);
}

bool MergedSource::thread_safe() const {
  return std::all_of(sources_.begin(), sources_.end(), [](const auto& source) { return source->thread_safe(); });
}

// The points that another rig than live_ gives for its clips are its own.
bool MergedSource::recorded(std::size_t clip) const {
  return origins_.at(clip).source != live_ || live_->recorded(origins_[clip].clip);
}

std::unique_ptr<EvaluationBackend> MergedSource::make_backend(const Parallel& parallel) {
  return live_ ? live_->make_backend(parallel) : Source::make_backend(parallel);
}

void MergedSource::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  if (!live_) return Source::evaluate(controls, count, points);
  live_->evaluate(controls, count, points);
}

}  // namespace fb::bake

#include "render/pose_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "base/status.h"
#include "render/colour_map.h"
#include "render/montage.h"
#include "render/shading.h"
#include "render/text.h"

namespace fb::tool {

namespace {

// Of the rest pose and other poses, the vertices that lie in the region at rest.
std::vector<float> points_in(const std::optional<BoundingBox>& region, std::span<const float> rest,
                             const MeshPoses& poses) {
  const auto inside = [&](Vector3 p) {
    return !region || (p.x >= region->low.x && p.x <= region->high.x && p.y >= region->low.y && p.y <= region->high.y &&
                       p.z >= region->low.z && p.z <= region->high.z);
  };
  std::vector<float> points;
  for (std::size_t v = 0; v < rest.size() / 3; ++v) {
    if (!inside(vector_at(rest.data(), v))) continue;
    points.insert(points.end(), &rest[3 * v], &rest[3 * v] + 3);
    for (const std::span<const float> pose : poses) points.insert(points.end(), &pose[3 * v], &pose[3 * v] + 3);
  }
  return points;
}

View whole(View view) {
  view.region.reset();
  view.margin = 0.04f;
  return view;
}

// Whether a pixel has this colour, however dark: light changes no hue.
bool shows(const Image& image, const std::array<float, 2>& pixel, Vector3 colour) {
  constexpr float same_hue = 0.995f;
  const int x = static_cast<int>(pixel[0]), y = static_cast<int>(pixel[1]);
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return false;
  const Rgb seen = image.at(x, y);
  const Vector3 share = {static_cast<float>(seen.r) / 255, static_cast<float>(seen.g) / 255,
                         static_cast<float>(seen.b) / 255};
  return dot(normalized(from_srgb(share)), normalized(colour)) > same_hue;
}

// The one that is nearest to the mean of all.
std::array<float, 2> middle_of(const std::vector<std::array<float, 2>>& pixels) {
  float x = 0, y = 0;
  for (const auto& pixel : pixels) {
    x += pixel[0] / static_cast<float>(pixels.size());
    y += pixel[1] / static_cast<float>(pixels.size());
  }
  const auto distance = [&](const auto& pixel) { return std::hypot(pixel[0] - x, pixel[1] - y); };
  return *std::min_element(pixels.begin(), pixels.end(),
                           [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
}

// Black, with a white outline.
void draw_number(Image& image, const std::array<float, 2>& pixel, std::size_t number) {
  constexpr int magnification = 2;
  const std::string text = std::to_string(number);
  const int left = static_cast<int>(pixel[0]) - text_width(text, magnification) / 2,
            top = static_cast<int>(pixel[1]) - text_height(magnification) / 2;
  for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-2, 0}, {2, 0}, {0, -2}, {0, 2}})
    draw_text(image, left + dx, top + dy, text, {255, 255, 255}, magnification);
  draw_text(image, left, top, text, {0, 0, 0}, magnification);
}

}  // namespace

PoseRenderer::PoseRenderer(const MeshView& rest, const MeshPoses& poses, const std::string& up_axis, const View& view,
                           const Resolution& resolution, const Parallel& parallel,
                           std::shared_ptr<const Appearance> appearance)
    : triangles_(rest.triangles()),
      diagonal_(rest.diagonal()),
      resolution_(resolution),
      parallel_(parallel),
      camera_(fit_camera(points_in(view.region, rest.points, poses), up_axis, whole(view),
                         static_cast<float>(resolution.width) / static_cast<float>(resolution.height))),
      appearance_(std::move(appearance)) {}

Image PoseRenderer::draw(std::span<const float> points) const {
  return render({.triangles = triangles_, .points = points, .appearance = appearance_.get()}, camera_, resolution_,
                parallel_);
}

Image PoseRenderer::draw_scalars(std::span<const float> points, std::span<const float> scalars,
                                 const ColourScale& scale) const {
  return render({.triangles = triangles_, .points = points, .scalars = scalars, .scale = scale}, camera_, resolution_,
                parallel_);
}

Image PoseRenderer::draw_parts(std::span<const float> points, std::span<const std::size_t> parts,
                               std::size_t count) const {
  constexpr Vector3 grey = {0.55f, 0.56f, 0.58f};
  constexpr std::size_t least_seen = 5;
  std::vector<Vector3> colours;
  for (const std::size_t part : parts) {
    const Rgb c = part_colour(part);
    const Vector3 share = {static_cast<float>(c.r) / 255, static_cast<float>(c.g) / 255, static_cast<float>(c.b) / 255};
    colours.push_back(part < count ? from_srgb(share) : grey);
  }
  Image image =
      render({.triangles = triangles_, .points = points, .colours = colours}, camera_, resolution_, parallel_);
  const Image plain = image;
  for (std::size_t part = 0; part < count; ++part) {
    std::vector<std::array<float, 2>> seen;  // pixels
    for (std::size_t v = 0; v < parts.size(); ++v) {
      if (parts[v] != part) continue;
      const auto [x, y] = camera_.project(vector_at(points.data(), v));
      const std::array<float, 2> pixel = {x * static_cast<float>(plain.width), y * static_cast<float>(plain.height)};
      if (shows(plain, pixel, colours[v])) seen.push_back(pixel);
    }
    if (seen.size() >= least_seen) draw_number(image, middle_of(seen), part + 1);
  }
  return image;
}

void PoseRenderer::draw_ring(Image& image, Vector3 point) const {
  constexpr int outer = 11, inner = 8;
  const auto [x, y] = camera_.project(point);
  const int column = static_cast<int>(x * static_cast<float>(image.width)),
            row = static_cast<int>(y * static_cast<float>(image.height));
  for (int dy = -outer; dy <= outer; ++dy)
    for (int dx = -outer; dx <= outer; ++dx) {
      const int squared = dx * dx + dy * dy;
      if (squared > outer * outer || squared < inner * inner) continue;
      const int px = column + dx, py = row + dy;
      if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
      image.at(px, py) = squared > (outer - 1) * (outer - 1) ? Rgb{255, 255, 255} : Rgb{30, 60, 160};
    }
}

PoseRenderer::Difference PoseRenderer::difference(std::span<const float> reference, std::span<const float> face,
                                                  std::vector<float>* distances) const {
  Difference difference;
  const std::size_t vertices = reference.size() / 3;
  double squares = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    const double distance = length(vector_at(face.data(), v) - vector_at(reference.data(), v)) / diagonal_;
    if (distances) distances->push_back(static_cast<float>(distance));
    squares += distance * distance;
    if (distance <= difference.max) continue;
    difference.max = distance;
    difference.vertex = v;
  }
  difference.rms = std::sqrt(squares / static_cast<double>(vertices));
  return difference;
}

PoseRenderer::Comparison PoseRenderer::draw_comparison(const Pose& reference, const std::vector<Pose>& faces,
                                                       ColourBar bar) const {
  Comparison comparison;
  std::vector<Panel> panels = {{draw(reference.points), reference.caption, {}}};
  std::vector<std::vector<float>> distances(faces.size());
  double max = 0;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    comparison.differences.push_back(difference(reference.points, faces[f].points, &distances[f]));
    max = std::max(max, comparison.differences.back().max);
    panels.push_back({draw(faces[f].points), faces[f].caption, {}});
  }
  if (!(bar.scale.end > 0)) bar.scale.end = round_scale(static_cast<float>(max));
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::string title = faces.size() > 1 ? faces[f].caption + " error" : "error / diagonal";
    const Difference& worst = comparison.differences[f];
    Image errors = draw_scalars(faces[f].points, distances[f], bar.scale);
    draw_ring(errors, vector_at(faces[f].points.data(), worst.vertex));
    panels.push_back({std::move(errors), format("%s\nrms %.1e, max %.1e", title.c_str(), worst.rms, worst.max),
                      f + 1 == faces.size() ? std::optional(bar) : std::nullopt});
  }
  comparison.image = make_montage(panels);
  return comparison;
}

}  // namespace fb::tool

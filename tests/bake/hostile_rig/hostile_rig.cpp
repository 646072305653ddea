// A small sheet with six controls that does one thing which no rig should, named by the environment variable FB_FAULT:
// it throws, prints, crashes, hangs, ends the process, or gives points that are far away, tiny, huge or different each
// time.
#include <facebaker/facebaker_rig.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

constexpr std::uint32_t side = 8, vertices = side * side, controls = 6;

struct Sheet {
  std::string fault;
  float scale = 1;
  std::uint64_t answers = 0;  // poses evaluated so far
  std::vector<std::string> names;
  std::vector<fb_rig_control> declared;
  std::vector<float> rest;
  std::vector<std::uint32_t> sizes, corners;

  bool is(const char* name) const { return fault == name; }
};

float noise(std::uint64_t number) {
  std::uint64_t x = (number + 1) * 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return static_cast<float>(x >> 40) / 0x1p23f - 1;
}

// Each control lifts a strip, bends it with its square, and two together move a corner.
void deform(const Sheet& sheet, const float* pose, float* points) {
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const float x = static_cast<float>(v % side), y = static_cast<float>(v / side);
    for (std::uint32_t c = 0; c < controls; ++c) {
      const float strip = std::exp(-(x - static_cast<float>(c)) * (x - static_cast<float>(c)));
      points[3 * v + 2] += sheet.scale * strip * (pose[c] + 0.4f * pose[c] * pose[c]);
    }
    points[3 * v] += sheet.scale * 0.3f * pose[0] * pose[1] * y / side;
  }
}

void spoil(Sheet& sheet, const float* pose, float* points) {
  if (sheet.is("far vertex") && pose[1] > 0.5f) points[3 * 17] = 1e10f;
  if (sheet.is("huge points"))
    for (std::uint32_t v = 0; v < vertices; ++v) points[3 * v] += pose[3] * pose[3] * 3e38f;
  if (sheet.is("huge linear points"))
    for (std::uint32_t v = 0; v < vertices; ++v) points[3 * v] += pose[3] * 1e30f;
  const bool moved = pose[0] + pose[1] + pose[2] + pose[3] + pose[4] + pose[5] > 0;
  if (sheet.is("noise") && moved)  // 0.06 % of the diagonal
    for (std::uint32_t i = 0; i < 3 * vertices; ++i) points[i] += 0.006f * noise(sheet.answers * 3 * vertices + i);
}

fb_status evaluate(void* user, std::uint64_t poses, const float* pose, float* points, char*, std::uint32_t) {
  Sheet& sheet = *static_cast<Sheet*>(user);
  for (std::uint64_t p = 0; p < poses; ++p, pose += controls, points += 3 * vertices) {
    const bool active = pose[2] > 0.25f, combined = pose[2] > 0.6f && pose[3] > 0.6f;
    if (active && sheet.is("throws a number")) throw 42;
    if (active && sheet.is("throws an exception")) throw std::runtime_error("the brow is missing");
    if (active && sheet.is("exits")) std::exit(0);
    if (combined && sheet.is("throws on a pose")) throw std::runtime_error("the brow is missing");
    if (combined && sheet.is("crashes")) std::raise(SIGKILL);
    if (combined && sheet.is("hangs")) std::this_thread::sleep_for(std::chrono::hours(1));
    if (sheet.is("is slow")) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (sheet.is("prints")) std::printf("the sheet evaluates a pose\n");
    if (active && sheet.is("exits quickly")) std::quick_exit(0);
    std::memcpy(points, sheet.rest.data(), sheet.rest.size() * sizeof(float));
    deform(sheet, pose, points);
    spoil(sheet, pose, points);
    ++sheet.answers;
  }
  return FB_OK;
}

void destroy(void* user) {
  const bool throws = static_cast<Sheet*>(user)->is("throws when destroyed");
  delete static_cast<Sheet*>(user);
  if (throws) throw 43;
}

void build(Sheet& sheet) {
  for (std::uint32_t c = 0; c < controls; ++c) sheet.names.push_back("strip" + std::to_string(c));
  for (const std::string& name : sheet.names) sheet.declared.push_back({name.c_str(), nullptr, 0, 1, 0, 0});
  for (std::uint32_t v = 0; v < vertices; ++v)
    for (const float x : {float(v % side), float(v / side), 0.1f * float(v % 3)}) sheet.rest.push_back(sheet.scale * x);
  for (std::uint32_t v = 0; v + side < vertices; ++v) {
    if (v % side == side - 1) continue;
    sheet.sizes.push_back(4);
    sheet.corners.insert(sheet.corners.end(), {v, v + 1, v + 1 + side, v + side});
  }
}

}  // namespace

extern "C" FB_API fb_status fb_rig_open(const char*, fb_rig* rig, char*, std::uint32_t) {
  auto owned = std::make_unique<Sheet>();
  Sheet* const sheet = owned.get();
  if (const char* fault = std::getenv("FB_FAULT")) sheet->fault = fault;
  if (sheet->is("prints")) std::printf("the sheet is opened\n");
  if (sheet->is("throws when opened")) throw "no licence";
  if (sheet->is("exits when opened")) std::exit(0);
  if (sheet->is("tiny")) sheet->scale = 1e-20f;
  if (sheet->is("gigantic")) sheet->scale = 1e20f;
  build(*sheet);
  fb_rig_init(rig);
  rig->name = "sheet";
  rig->units = "cm";
  rig->up_axis = "y";
  rig->control_count = controls;
  rig->controls = sheet->declared.data();
  rig->vertex_count = vertices;
  rig->rest_positions = sheet->rest.data();
  rig->polygon_count = sheet->is("no polygons") ? 0 : static_cast<std::uint32_t>(sheet->sizes.size());
  rig->polygon_sizes = sheet->is("no polygons") ? nullptr : sheet->sizes.data();
  rig->polygon_corners = sheet->is("no polygons") ? nullptr : sheet->corners.data();
  rig->user = owned.release();
  rig->evaluate = evaluate;
  rig->destroy = destroy;
  return FB_OK;
}

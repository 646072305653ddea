#include "loaded_rig.h"

#include <dlfcn.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <thread>

#include "support/rig_folder.h"

LoadedRig::LoadedRig(const char* file) {
  library_ = dlopen(file, RTLD_NOW | RTLD_LOCAL);
  REQUIRE_MESSAGE(library_, dlerror());
  const auto open = reinterpret_cast<fb_rig_open_function>(dlsym(library_, FB_RIG_OPEN_SYMBOL));
  const bool found = open != nullptr;
  REQUIRE(found);
  char text[512] = "";
  status = open(file, &rig_, text, sizeof text);
  message = text;
}

LoadedRig::~LoadedRig() {
  if (status == FB_OK) rig_.destroy(rig_.user);
  if (library_) dlclose(library_);
}

std::vector<float> LoadedRig::evaluate(const std::vector<float>& controls) const {
  const std::size_t poses = controls.size() / rig_.control_count;
  std::vector<float> positions(poses * 3 * rig_.vertex_count);
  char text[512] = "";
  REQUIRE_MESSAGE(rig_.evaluate(rig_.user, poses, controls.data(), positions.data(), text, sizeof text) == FB_OK, text);
  return positions;
}

double LoadedRig::diagonal() const {
  double squares = 0;
  for (int axis = 0; axis < 3; ++axis) {
    float low = rig_.rest_positions[axis], high = low;
    for (std::size_t vertex = 0; vertex < rig_.vertex_count; ++vertex) {
      low = std::min(low, rig_.rest_positions[3 * vertex + axis]);
      high = std::max(high, rig_.rest_positions[3 * vertex + axis]);
    }
    squares += (double{high} - low) * (double{high} - low);
  }
  return std::sqrt(squares);
}

std::string LoadedRig::group(const std::string& control) const {
  for (std::size_t i = 0; i < rig_.control_count; ++i) {
    if (rig_.controls[i].name == control) return rig_.controls[i].group;
  }
  return "";
}

bool have_data(const char* folder) {
  try {
    rigs::RigFolder{folder};
    return true;
  } catch (const std::runtime_error& error) {
    std::printf("skipped: %s\n", error.what());
    return false;
  }
}

double largest_difference(const std::vector<float>& a, const std::vector<float>& b) {
  REQUIRE(a.size() == b.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double difference = std::abs(double{a[i]} - b[i]);
    REQUIRE(std::isfinite(difference));
    largest = std::max(largest, difference);
  }
  return largest;
}

void check_promises(const LoadedRig& rig, const std::vector<float>& controls) {
  const std::size_t numbers = 3 * std::size_t{rig->vertex_count}, count = rig->control_count;
  std::size_t corners = 0;
  for (std::size_t i = 0; i < rig->polygon_count; ++i) {
    REQUIRE(rig->polygon_sizes[i] >= 3);
    corners += rig->polygon_sizes[i];
  }
  for (std::size_t i = 0; i < corners; ++i) REQUIRE(rig->polygon_corners[i] < rig->vertex_count);

  std::vector<float> rest(count);
  for (std::size_t i = 0; i < count; ++i) rest[i] = rig->controls[i].rest;
  CHECK(rig.evaluate(rest) == std::vector<float>(rig->rest_positions, rig->rest_positions + numbers));

  const std::vector<float> block = rig.evaluate(controls);
  CHECK((rig->flags & FB_RIG_THREAD_SAFE) != 0);
  std::vector<float> one_by_one(block.size());
  std::vector<std::thread> threads;
  for (std::size_t thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&, thread] {
      for (std::size_t pose = thread; pose < controls.size() / count; pose += 4)
        rig->evaluate(rig->user, 1, controls.data() + pose * count, one_by_one.data() + pose * numbers, nullptr, 0);
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(one_by_one == block);
}

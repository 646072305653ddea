#include <doctest/doctest.h>
#include <facebaker/facebaker.hpp>

#include <algorithm>
#include <fstream>

TEST_CASE("a face is loaded, posed and shared") {
  facebaker::Model model(FB_FIXTURE);
  CHECK(model.name() == "tiny");
  std::vector<float> controls = model.rest_controls(), positions(3 * model.vertex_count());
  facebaker::Scratch scratch(model);
  scratch.evaluate(controls.data(), positions.data());
  CHECK(std::equal(positions.begin(), positions.end(), model.rest_positions()));

  const facebaker::Model copy = model;
  model = facebaker::Model(FB_FIXTURE);
  CHECK(copy.get() != model.get());
  controls[copy.find("jaw_open")] = 2;
  scratch.evaluate(controls.data(), positions.data());
  CHECK(scratch.clamped_count() == 1);
  CHECK(!std::equal(positions.begin(), positions.end(), copy.rest_positions()));
  CHECK(std::string(copy.control(3).name) == "lid_close");
}

TEST_CASE("a face is loaded from a stream") {
  std::ifstream file(FB_FIXTURE, std::ios::binary);
  const auto read = [](void* user, void* to, std::uint64_t bytes) -> std::int64_t {
    auto& stream = *static_cast<std::ifstream*>(user);
    stream.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
    return stream.bad() ? -1 : stream.gcount();
  };
  const facebaker::Model model(read, &file);
  CHECK(model.name() == "tiny");
}

TEST_CASE("errors are exceptions with a status") {
  try {
    facebaker::Model("/nowhere/face.fbk");
    FAIL("no exception");
  } catch (const facebaker::Error& error) {
    CHECK(error.status() == FB_ERROR_NOT_FOUND);
    CHECK(std::string(error.what()).find("/nowhere/face.fbk") != std::string::npos);
  }
}

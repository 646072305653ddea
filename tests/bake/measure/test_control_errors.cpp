#include "bake/measure/control_errors.h"

#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "bake/measure/certificate.h"
#include "toy_faces.h"

namespace test_control_errors {

using namespace fb;
using namespace fb::bake;

namespace {

// Control 1 alone does what no face can learn; 2 does so where 0 is active, and control 3 is plain.
void unlearnable_formula(const float* c, std::span<float> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float shape = std::cos(0.3f * static_cast<float>(i));
    points[i] += 0.3f * c[3] * shape + 0.2f * std::sin(3000 * c[1]) * shape;
    points[i] += 0.4f * c[0] * std::sin(3000 * c[2]) * shape;
  }
}

Baked baked_face(MemorySource& rig) {
  const WorkFolder folder;
  BakeOptions options = options_in(folder, "compact");
  options.poses = 400;
  options.epochs = 2;
  return bake_face(rig, options, silent_progress());
}

}  // namespace

TEST_CASE("what cannot be learnt is named by control, in warnings and certificate, and nothing else is") {
  MemorySource rig(4, 5, unlearnable_formula, true);
  const Baked baked = baked_face(rig);
  REQUIRE(baked.controls.size() == 4);
  CHECK(baked.controls[1].alone > 0.02);
  CHECK(baked.controls[2].alone < 5e-3);
  CHECK(baked.controls[2].among > 0.02);
  CHECK(baked.controls[3].alone < 5e-3);  // precision follows from what networks leave over
  const std::vector<ControlError> named = unlearnt_controls(baked.controls);
  REQUIRE(named.size() >= 2);
  CHECK(std::ranges::count(named, "control1", &ControlError::name) == 1);
  const nlohmann::json certificate = nlohmann::json::parse(archive::read_archive(baked.archive).text.certificate);
  REQUIRE(certificate.at("warnings").size() == named.size());
  CHECK(certificate["warnings"][0] == warning_of(named[0]));
  for (const ControlError& error : named) {
    CHECK(error.name != "control3");
    CHECK(std::ranges::count(baked.warnings, warning_of(error)) == 1);
  }
}

TEST_CASE("a control is not named for a single pose, but for most of what it does") {
  const std::vector<ControlError> errors = {{"off in one pose", 1e-3, 0.1, 0.035, 0.2},
                                            {"off among others", 1e-3, 0.1, 0.035, 1.0},
                                            {"off alone", 0.03, 0.05, 1e-3, 0.01},
                                            {"moves little", 4e-3, 4e-3, 0.01, 0.9}};
  const std::vector<ControlError> named = unlearnt_controls(errors);
  REQUIRE(named.size() == 2);
  CHECK(named[0].name == "off among others");
  CHECK(warning_of(named[0]).find("not among many others") != std::string::npos);
  CHECK(named[1].name == "off alone");
  CHECK(warning_of(named[1]).find("is not reproduced") != std::string::npos);
}

TEST_CASE("errors of controls are those of the packed face, and no control of a face that is right is named") {
  MemorySource rig = face_of(linear_formula, true);
  const Baked baked = baked_face(rig);
  REQUIRE(baked.controls.size() == 4);
  for (const ControlError& error : baked.controls) {
    CHECK(error.alone > 0);  // rounding
    CHECK(error.alone < 1e-3);
    CHECK(error.among < 1e-3);
  }
  CHECK(unlearnt_controls(baked.controls).empty());
  const std::string certificate = archive::read_archive(baked.archive).text.certificate;
  CHECK_FALSE(nlohmann::json::parse(certificate).contains("warnings"));
}

TEST_CASE("a budget that does not allow for it leaves controls unmeasured") {
  MemorySource rig = face_of(linear_formula, true);
  const WorkFolder folder;
  BakeOptions options = options_in(folder, "linear");
  options.rig_budget = 100;
  const Baked baked = bake_face(rig, options, silent_progress());
  CHECK(baked.controls.empty());
  CHECK(baked.asked <= 100);
}

}  // namespace test_control_errors

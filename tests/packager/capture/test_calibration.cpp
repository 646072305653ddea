// Calibrations: how they are found, kept and applied.
#include <doctest/doctest.h>

#include "base/status.h"
#include "capture/calibration_recorder.h"

using namespace fb::tool;

namespace test_calibration {
namespace {

std::string refusal(const std::string& text) {
  try {
    parse_calibration(text);
  } catch (const fb::Error& error) {
    return error.what();
  }
  return "";
}

std::string with_jaw(const std::string& jaw) {
  return R"({"format": "facebaker-capture-calibration", "version": 1, "names": {"jawOpen": )" + jaw + "}}";
}

}  // namespace

TEST_CASE("a value goes from the neutral value, 0, to the range, 1") {
  CaptureCalibration calibration;
  calibration.names["jawOpen"] = {0.25F, 0.75F};
  CHECK(calibration.apply("jawOpen", 0.25F) == 0);
  CHECK(calibration.apply("jawOpen", 0.5F) == 0.5);
  CHECK(calibration.apply("jawOpen", 0.75F) == 1);
  CHECK(calibration.apply("jawOpen", 0) == -0.5);
  CHECK(calibration.apply("mouthPucker", 0.3F) == 0.3F);
}

TEST_CASE("the neutral value is the median of the relaxed part, the range the third largest value") {
  CalibrationRecorder recorder(6, {"headYaw"});
  CHECK(recorder.relaxed_seconds() == 2);
  const std::vector<std::string> names = {"jawOpen", "cheekPuff", "headYaw"};
  const auto take = [&](double seconds, float jaw) {
    recorder.take(names, std::vector<float>{jaw, 0.05F, 0.3F}, seconds);
  };
  for (int frame = 0; frame < 20; ++frame) take(0.1 * frame, frame == 7 ? 0.9F : 0.1F);  // one that is off
  for (const float jaw : {0.2F, 0.8F, 0.7F, 0.75F, 0.6F}) take(3, jaw);
  const CaptureCalibration found = recorder.calibration();
  CHECK(found.names.at("jawOpen").neutral == 0.1F);
  CHECK(found.names.at("jawOpen").range == 0.75F);
  CHECK(found.names.at("cheekPuff").neutral == 0.05F);
  CHECK(found.names.at("cheekPuff").range == 1);  // it did not move
  CHECK(found.names.at("headYaw").neutral == 0.3F);
  CHECK(found.names.at("headYaw").range == 1.3F);
  CHECK(recorder.still_names() == std::vector<std::string>{"cheekPuff"});
}

TEST_CASE("names that come later have a neutral value of 0") {
  CalibrationRecorder recorder(30, {});
  CHECK(recorder.relaxed_seconds() == 3);
  recorder.take({"A"}, std::vector<float>{0.5F}, 0);
  for (int frame = 0; frame < 3; ++frame) recorder.take({"A", "Joy"}, std::vector<float>{0.5F, 0.6F}, 5);
  CHECK(recorder.calibration().names.at("A").range == 1);
  CHECK(recorder.calibration().names.at("Joy").neutral == 0);
  CHECK(recorder.calibration().names.at("Joy").range == 0.6F);
}

TEST_CASE("what is recorded is kept as text and read again, whatever the values were") {
  CalibrationRecorder recorder(3, {"turn"});
  const std::vector<std::string> names = {"large", "small", "turn", "quote \" and ü"};
  for (int frame = 0; frame < 9; ++frame)
    recorder.take(names, std::vector<float>{3e38F, -3e38F, 3e38F, 0.1F * static_cast<float>(frame)}, 0.3 * frame);
  const CaptureCalibration made = recorder.calibration();
  const CaptureCalibration read = parse_calibration(calibration_text(made));
  REQUIRE(read.names.size() == names.size());
  for (const auto& [name, calibrated] : made.names) {
    CHECK(read.names.at(name).neutral == calibrated.neutral);
    CHECK(read.names.at(name).range == calibrated.range);
  }
}

TEST_CASE("what is wrong with a calibration is told by its field") {
  CHECK(refusal(with_jaw(R"({"neutral": 0.1, "range": 0.7})")) == "");
  CHECK(refusal("{") == "this is no JSON object");
  CHECK(refusal("{}") == "there is no \"format\"");
  CHECK(refusal(R"({"format": "x", "version": 1, "names": {}})").find("\"format\" is not") == 0);
  CHECK(refusal(R"({"format": "facebaker-capture-calibration", "version": 2, "names": {}})") == "\"version\" is not 1");
  CHECK(refusal(R"({"format": "facebaker-capture-calibration", "version": 1, "names": []})") ==
        "\"names\" is no object");
  CHECK(refusal(with_jaw("3")) == "\"names.jawOpen\" is no object");
  CHECK(refusal(with_jaw(R"({"neutral": 0.1})")) == "there is no \"names.jawOpen.range\"");
  CHECK(refusal(with_jaw(R"({"neutral": 0.1, "range": 1, "gain": 1})")) ==
        "\"names.jawOpen.gain\" is no field of a calibration");
  CHECK(refusal(with_jaw(R"({"neutral": 1e9, "range": 1})")) ==
        "\"names.jawOpen.neutral\" is no number from -1000 to 1000");
  CHECK(refusal(with_jaw(R"({"neutral": null, "range": 1})")) ==
        "\"names.jawOpen.neutral\" is no number from -1000 to 1000");
  CHECK(refusal(with_jaw(R"({"neutral": 0.5, "range": 0.5})")) ==
        "\"names.jawOpen.range\" is 0.5, and 0.1 above the neutral value 0.5 at least expected");
  CHECK(refusal(std::string(100, '[')) != "");
}

}  // namespace test_calibration

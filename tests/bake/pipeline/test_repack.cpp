// Repacking within limits: what is met, what is refused and what is forced.
#include "bake/pipeline/repack.h"

#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/measure/certificate.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "base/status.h"
#include "temporary_folder.h"
#include "test_models.h"

namespace test_repack {

using namespace fb;
using namespace fb::bake;

namespace {

using Bytes = std::vector<std::byte>;

Bytes face_with(const std::string& certificate) {
  const PackedModel model = tiny_packed_model();
  return archive::write_archive(model, make_proof(model, 1), {"", certificate});
}

RepackResult packed(const Bytes& archive, const RepackOptions& options) {
  return repack(archive, options, silent_progress());
}

std::string certificate_of(const Bytes& archive) {
  return archive::read_archive(archive).text.certificate;
}

}  // namespace

TEST_CASE("without limits an archive stays what it was") {
  const Bytes face = face_with("{\"dependency\":null}");
  const RepackResult result = packed(face, {});
  CHECK(result.archive == face);
  CHECK(result.bytes == face.size());
  CHECK(result.source_bytes == face.size());
  CHECK(result.factor == 1);
  CHECK(archive::read_archive(packed(face, {.licence = "Mine."}).archive).text.licence == "Mine.");
  CHECK(packed(face, {.max_bytes = face.size()}).archive == face);
}

TEST_CASE("bytes and errors are kept to, and the certificate says what it took") {
  const Bytes face = face_with(R"({"independent":{"rms":0.05,"max":0.5}})");
  // The search takes bytes to fall and the error to grow with the steps. Of so small a face they do not at every step;
  // for this size, where steps are 9.5 times as large, they do at those that the search tries.
  const std::uint64_t fewer = face.size() - 600;
  const RepackResult small = packed(face, {.max_bytes = fewer});
  CHECK(small.bytes <= fewer);
  CHECK(small.bytes == small.archive.size());
  CHECK(small.factor > 1);
  CHECK(small.within_limits);
  CHECK(small.max_error == 0.5);
  CHECK(small.displacement.max > 0);
  CHECK(verify_archive(small.archive).poses == 11);
  const auto json = nlohmann::json::parse(certificate_of(small.archive));
  CHECK(json["repacked"]["max"].get<double>() == doctest::Approx(small.displacement.max).epsilon(1e-5));
  CHECK(json["bound"]["max"].get<double>() == doctest::Approx(0.5 + small.displacement.max).epsilon(1e-5));
  CHECK(json["bound"]["mse"].get<double>() ==
        doctest::Approx(std::pow(0.05 + small.displacement.rms, 2)).epsilon(1e-4));

  const RepackResult exact = packed(face, {.max_error = small.displacement.max});
  CHECK(exact.displacement.max <= small.displacement.max);
  CHECK(exact.bytes <= small.bytes);
}

TEST_CASE("what cannot be had is refused with what could be, and written only by force") {
  const Bytes face = face_with(R"({"independent":{"rms":0.05,"max":0.5}})");
  const std::uint64_t fewer = face.size() - 300;
  const RepackResult small = packed(face, {.max_bytes = fewer});
  const double less = small.displacement.max / 2;
  const auto refused = [&](const RepackOptions& options) -> std::string {
    try {
      packed(face, options);
    } catch (const Error& error) {
      CHECK(error.status() == Status::limit);
      return error.what();
    }
    return "";
  };
  const auto names = [](const std::string& message, const std::string& part) {
    CHECK_MESSAGE(message.find(part) != std::string::npos, message << " lacks " << part);
  };
  const std::string message = refused({.max_bytes = fewer, .max_error = less});
  names(message, "within them (" + std::to_string(small.bytes) + " bytes)");
  names(message, "it takes " + std::to_string(packed(face, {.max_error = less}).bytes) + " bytes");
  const RepackResult forced = packed(face, {.max_bytes = fewer, .max_error = less, .force = true});
  CHECK(forced.archive == small.archive);
  CHECK_FALSE(forced.within_limits);

  const RepackResult smallest = packed(face, {.max_bytes = 10, .force = true});
  CHECK(smallest.factor == 1024);
  CHECK(smallest.bytes > 10);
  names(refused({.max_bytes = 10}), "the smallest there is has " + std::to_string(smallest.bytes) + " bytes");
  for (const double wrong : {-1.0, double(NAN), HUGE_VAL})
    CHECK_THROWS_WITH(packed(face, {.max_error = wrong}), doctest::Contains("max_error"));
}

TEST_CASE("the error allowed by default is what the certificate leaves") {
  CHECK(default_repack_error("") == 0.01);
  CHECK(default_repack_error("[3]") == 0.01);
  CHECK(default_repack_error(R"({"dependency":{"max":0.3},"independent":{"max":0.2}})") == 0.3);
  CHECK(default_repack_error(R"({"dependency":null,"independent":{"max":0.2},"repacked":{"max":0.15}})") ==
        doctest::Approx(0.05));
  CHECK(default_repack_error(R"({"independent":{"max":0.2},"repacked":{"max":0.25}})") == 0);
  const Bytes face = face_with(R"({"independent":{"rms":1e-7,"max":1e-6}})");
  CHECK_THROWS_WITH(packed(face, {.max_bytes = face.size() - 300}), doctest::Contains("by default"));
}

TEST_CASE("a failure leaves the file that was there") {
  const test::Folder folder;
  const auto in = folder / "in.fbk", out = folder / "out.fbk";
  write_file(in, face_with(""));
  write_file(out, std::string("old"));
  const auto old = read_file(out);
  // Verification reads what is on the disk: an archive whose reference poses are not its own is never renamed.
  archive::Archive wrong = archive::read_archive(read_file(in));
  wrong.proof.hashes[0] ^= 1;
  const Bytes bytes = archive::write_archive(wrong.model, wrong.proof);
  CHECK_THROWS_WITH(write_verified_archive(out, bytes), doctest::Contains("does not pose as it did"));
  CHECK(read_file(out) == old);
  const Bytes good = face_with("");
  CHECK_THROWS_AS(write_verified_archive(out, std::span(good).first(100)), Error);
  CHECK(read_file(out) == old);
  CHECK(folder.entries() == 2);
  write_verified_archive(out, good);
  CHECK(read_file(out) == good);
  std::filesystem::remove(out);
  std::filesystem::create_directory(out);
  CHECK_THROWS_WITH(write_verified_archive(out, good), doctest::Contains("is a directory"));
  CHECK_THROWS_AS(write_verified_archive(folder / "missing/out.fbk", good), Error);
}

}  // namespace test_repack

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <facebaker/facebaker_bake.hpp>
#include <stdexcept>

TEST_CASE("an archive is described, inspected and verified") {
  facebaker::Archive archive(FB_FIXTURE);
  const fb_archive_info info = archive.info();
  CHECK(std::string(info.name) == "tiny");
  CHECK(archive.section(0).stored_bytes > 0);
  const fb_region region = archive.region(0);
  CHECK(archive.layer(0, 0).inputs == region.input_count);
  CHECK(facebaker::inspect(archive).json().find("\"tiny\"") != std::string::npos);

  const facebaker::Archive copy(info.bytes, info.byte_count, "copy");
  const facebaker::Report report = facebaker::verify(copy);
  CHECK(report.method_count() == 0);
  CHECK(report.json().find("\"copy\"") != std::string::npos);
  CHECK_THROWS_AS(report.details(), facebaker::Error);

  archive = facebaker::Archive(FB_FIXTURE);
  CHECK(archive.info().byte_count == info.byte_count);
}

TEST_CASE("a source is described, read and evaluated") {
  const facebaker::Source source({FB_TOY_RIG});
  const facebaker::SourceView view(source);
  CHECK(view.live());
  CHECK(std::string(view.control(0).name).size() > 0);
  const fb_clip clip = view.clip(0);
  REQUIRE(clip.frames > 1);
  const std::vector<float> recorded = view.read(0, 1, 1);
  CHECK(recorded.size() == 3 * view.info().vertex_count);
  CHECK(recorded == view.evaluate(clip.controls + view.info().control_count, 1));
  try {
    view.check_model(facebaker::Model(FB_FIXTURE));
    FAIL("no exception");
  } catch (const facebaker::Error& error) {
    CHECK(error.status() == FB_ERROR_BAD_DATA);
  }
}

TEST_CASE("what a function throws that draws thumbnails is a note, and the face is baked without") {
  const facebaker::Source source({FB_TOY_RIG});
  fb_bake_desc desc;
  fb_bake_desc_init(&desc);
  desc.source = source.get();
  desc.archive = "thrown_thumbnail.fbk";
  desc.recipe = "linear";
  desc.poses = 100;
  desc.draw_thumbnail = [](void*, const void*, std::uint64_t, void*, std::uint64_t*, char*,
                           std::uint32_t) -> fb_status { throw std::runtime_error("no pens"); };
  std::string last_note;
  desc.callbacks.user = &last_note;
  desc.callbacks.note = [](void* user, const char* sentence) { *static_cast<std::string*>(user) = sentence; };
  const facebaker::Report report = facebaker::bake(desc);
  CHECK(last_note == "the archive has no thumbnail: draw_thumbnail threw an exception: no pens");
  const facebaker::Archive archive(desc.archive);
  CHECK(archive.info().thumbnail == nullptr);
  std::remove(desc.archive);
}

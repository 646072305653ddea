// What users name to be kept exact.
#include "bake/sampling/named_frames.h"

#include <doctest/doctest.h>

#include "base/file.h"
#include "memory_source.h"
#include "model/exact_poses.h"
#include "temporary_folder.h"
#include "watched_progress.h"

namespace test_named_frames {

using namespace fb;
using namespace fb::bake;

namespace {

MemorySource clips_of(bool live = true) {
  MemorySource source(
      3, 3, [](const float*, std::span<float>) {}, live);
  source.add_clip("smile", ClipKind::shot, Split::train, 20, 1, 1);
  source.add_clip("smile:wide", ClipKind::shot, Split::train, 4, 1, 2);
  source.add_clip("unseen", ClipKind::shot, Split::test, 5, 1, 3);
  return source;
}

std::vector<std::string> names_of(const std::vector<NamedFrame>& frames) {
  std::vector<std::string> names;
  for (const NamedFrame& frame : frames) names.push_back(frame.name);
  return names;
}

void check_not_found(const MemorySource& source, const std::string& wanted, const char* message) {
  CHECK_THROWS_WITH_AS(find_named_frames({wanted}, source, silent_progress()), doctest::Contains(message), Error);
}

using Names = std::vector<std::string>;

TEST_CASE("frames are named by clip and number, or are all of a clip") {
  MemorySource source = clips_of();
  const auto frames = find_named_frames({"smile:12,3", "smile:wide:2"}, source, silent_progress());
  CHECK(names_of(frames) == Names{"smile:12", "smile:3", "smile:wide:2"});
  CHECK(frames[0].clip == 0);
  CHECK(frames[0].frame == 12);
  CHECK(frames[2].clip == 1);
  CHECK(std::ranges::equal(frames[0].controls, std::span(source.clips()[0].controls).subspan(36, 3)));
  CHECK(names_of(find_named_frames({"smile:wide"}, source, silent_progress())) ==
        Names{"smile:wide:0", "smile:wide:1", "smile:wide:2", "smile:wide:3"});
  CHECK(find_named_frames({}, source, silent_progress()).empty());
  test::Notes notes;
  CHECK(find_named_frames({"unseen"}, source, notes).size() == 5);
  CHECK(notes.all.find("5 poses that are kept exact are of clips that are not trained on") != std::string::npos);
}

TEST_CASE("what is exact anyhow, or already, is told and left out") {
  MemorySource source = clips_of();
  Clip& clip = source.edit_clip(0);
  std::fill_n(clip.controls.begin(), 3, 0.0f);                      // at rest
  std::copy_n(clip.controls.begin() + 3, 3, &clip.controls[6]);     // frame 2 is frame 1
  clip.controls[9] = 7, clip.controls[10] = clip.controls[11] = 0;  // outside of its range
  test::Notes notes;
  const auto frames = find_named_frames({"smile:0,1,2,3", "smile:1"}, source, notes);
  CHECK(names_of(frames) == Names{"smile:1", "smile:3"});
  CHECK(frames[1].controls == std::vector<float>{1, 0, 0});
  CHECK(notes.all ==
        "\"smile:0\" is the rest pose, which is exact in any case\n"
        "\"smile:2\" has the controls of \"smile:1\", which is kept exact\n"
        "\"smile:1\" has the controls of \"smile:1\", which is kept exact\n");
}

TEST_CASE("what is not there is refused, with the closest clip") {
  const MemorySource source = clips_of();
  check_not_found(source, "smiel:2",
                  "\"smiel:2\" is no clip of \"formula\", no CLIP:FRAME and no .csv or .npy; the "
                  "closest clip is \"smile\"");
  check_not_found(source, "unsen", "the closest clip is \"unseen\"");
  check_not_found(source, "smile:20", "clip \"smile\" has no frame 20: it has 20, counted from 0");
  check_not_found(source, "smile:", "\"\" are no frames of clip \"smile\"");
  check_not_found(source, "smile:1,", "\"1,\" are no frames");
  check_not_found(source, "smile:1;2", "\"1;2\" are no frames");
  check_not_found(source, "smile:-1", "\"-1\" are no frames");
  check_not_found(source, "smile:99999999999999999999", "are no frames");
  MemorySource bare(3, 3, [](const float*, std::span<float>) {});
  check_not_found(bare, "smile", "\"smile\" is no clip of \"formula\", no CLIP:FRAME and no .csv or .npy");
}

TEST_CASE("as many as an archive holds are kept, and no more") {
  MemorySource source = clips_of();
  source.add_clip("long", ClipKind::shot, Split::train, max_exact_poses, 1, 4);
  source.add_clip("longer", ClipKind::shot, Split::train, max_exact_poses + 1, 1, 5);
  CHECK(find_named_frames({"long"}, source, silent_progress()).size() == max_exact_poses);
  check_not_found(source, "longer", "1025 poses to keep exact, with those of \"longer\"; at most 1024 are supported");
  CHECK_THROWS_WITH_AS(find_named_frames({"smile:1", "long"}, source, silent_progress()),
                       doctest::Contains("1025 poses to keep exact, with those of \"long:1023\""), Error);
}

TEST_CASE("files of controls are evaluated by a live rig, and refused for a recording") {
  const test::Folder folder;
  const std::string file = (folder / "poses.csv").string();
  write_file(file, std::string("control0,control2\n0.5,0.25\n0,0\n-1,2\n"));
  const auto frames = find_named_frames({file, "smile:1"}, clips_of(), silent_progress());
  CHECK(names_of(frames) == Names{"poses.csv:0", "poses.csv:2", "smile:1"});
  CHECK(frames[0].controls == std::vector<float>{0.5f, 0, 0.25f});
  CHECK(frames[1].controls == std::vector<float>{-1, 0, 1});
  CHECK(!frames[0].clip);
  check_not_found(clips_of(false), file, "is a recording, which has its own frames only");
}

}  // namespace

}  // namespace test_named_frames

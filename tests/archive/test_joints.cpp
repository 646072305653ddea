// Joints and skins of an archive: what is inconsistent, cut short or forged is refused.
#include <doctest/doctest.h>

#include <functional>

#include "archive/writer.h"
#include "archive_editor.h"
#include "refusals.h"
#include "test_models.h"

namespace fb::test_joints {
namespace {

void check_unwritable(const std::function<void(PackedModel&)>& change, const char* message,
                      PackedModel model = body_model()) {
  change(model);
  CHECK_THROWS_WITH_AS(write_archive(model, {}), doctest::Contains(message), Error);
}

TEST_CASE("joints and skins that contradict themselves are refused") {
  using Model = PackedModel;
  const auto head = [](Model& m) -> Joint& { return m.character.joints[1]; };
  const auto skin = [](Model& m) -> Skin& { return m.character.skin; };
  check_unwritable([&](Model& m) { head(m).name = "neck"; }, "two joints named \"neck\"");
  check_unwritable([&](Model& m) { head(m).name = ""; }, "joint 1 has no name");
  check_unwritable([&](Model& m) { head(m).parent = 1; }, "joint \"head\" has the number 1 and its parent 1");
  check_unwritable([&](Model& m) { head(m).rest[3] = NAN; }, "joint \"head\" has a matrix that is not finite");
  check_unwritable([&](Model& m) { head(m).inverse_bind[11] = INFINITY; }, "joint \"head\" has a matrix");
  check_unwritable([&](Model& m) { m.character.joints.resize(2); }, "vertex 7 follows joint 2 of 2");
  check_unwritable([&](Model& m) { m.character.joints.clear(); }, "vertex 0 follows joint 1 of 0");
  check_unwritable([&](Model& m) { skin(m).influences = 33; }, "may follow 32");
  check_unwritable([&](Model& m) { skin(m).influences = 0; }, "a skin without influences");
  check_unwritable([&](Model& m) { skin(m).weights.pop_back(); }, "60 joints and 59 weights for 30 vertices");
  check_unwritable([&](Model& m) { skin(m).weights[0] = 1.002f; }, "vertex 0 has weights of joints that sum to 1.002");
  check_unwritable([&](Model& m) { skin(m).weights[0] = -1; }, "vertex 0 follows a joint by the weight -1");
  check_unwritable([&](Model& m) { skin(m).weights[0] = NAN; }, "vertex 0 follows a joint by the weight");
  check_unwritable([&](Model& m) { std::swap(skin(m).weights[2], skin(m).weights[3]); }, "after one of weight 0");
  check_unwritable([&](Model& m) { skin(m).weights[34] = skin(m).weights[35] = 0; }, "vertex 17 follows no joint");
  check_unwritable([&](Model& m) { skin(m).weights[58] = 1; }, "vertex 29 follows a joint, unlike");
}

TEST_CASE("outer rotations of driven joints have some of three numbers, and there are 15 at most") {
  const auto refused = [](std::vector<std::uint8_t> rotations, const char* message) {
    check_unwritable([&](PackedModel& m) { m.rest.driven.joints[3].outer_rotations = rotations; }, message,
                     driven_model());
  };
  refused({7, 0}, "driven joint \"lid\" has an outer rotation with the numbers 0x0");
  refused({8, 7}, "driven joint \"lid\" has an outer rotation with the numbers 0x8");
  refused(std::vector<std::uint8_t>(16, 1), "driven joint \"lid\" has 16 outer rotations; it may have 15");
  check_unwritable([](PackedModel& m) { m.rest.driven.joints[0].numbers |= 0x1000; },
                   "driven joint \"jaw\" has numbers that are unknown", driven_model());
}

TEST_CASE("frames are multiplied and inverted, and singular ones are not") {
  const Frame<double> a = {0, -2, 0, 1, 2, 0, 0, 2, 0, 0, 3, 3}, identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  REQUIRE(inverse(a));
  CHECK(product(a, *inverse(a)) == identity);
  CHECK(product(identity, a) == a);
  Frame<double> flat = a;
  for (const std::size_t i : {8, 9, 10}) flat[i] = flat[i - 4] + 1e-12;
  CHECK_FALSE(inverse(flat));
  CHECK_FALSE(inverse(Frame<double>{}));
  Frame<double> small = a;  // a small frame is no singular one
  for (double& x : small) x *= 1e-12;
  CHECK(inverse(small));

  // A skin is tidied: joints named twice, weights of 0, influences that no vertex has.
  Skin skin{4, {3, 1, 3, 0, 5, 6, 7, 8}, {0.25f, 0, 0.75f, 0, 0, 0, 0, 1}};
  tidy(skin);
  CHECK(skin == Skin{1, {3, 8}, {1, 1}});
  Skin none{2, {1, 1}, {0, 0}};
  tidy(none);
  CHECK(none == Skin{});
}

TEST_CASE("joints and skin are read as they were written") {
  const PackedModel model = body_model();
  CHECK(read_archive(write_archive(model, {})).model.character == model.character);
  // Without them an archive has no such sections.
  for (const auto& section : ArchiveEditor(write_archive(character_model(), {})).sections)
    CHECK((section.name != "joints" && section.name != "skin"));
  PackedModel joints = model;  // joints alone, such as those that sockets hang on
  joints.character.skin = {};
  CHECK(read_archive(write_archive(joints, {})).model.character == joints.character);
  const DrivenJoints driven = driven_model().rest.driven,
                     read = read_archive(write_archive(driven_model(), {})).model.rest.driven;
  CHECK(read.joints == driven.joints);
  CHECK(read.scales == driven.scales);
}

TEST_CASE("forged joints and skins are refused by name") {
  const Bytes bytes = write_archive(body_model(), {}), driven = write_archive(driven_model(), {});
  const auto lie = [&](const char* section, std::size_t at, auto value, Status status, const char* message) {
    ArchiveEditor archive(section == std::string("driven-joints") ? driven : bytes);
    Bytes contents = archive[section].stored;
    patch(contents, at, value);
    archive[section].set(contents);
    check_refused(archive.bytes(), status, message);
  };
  lie("joints", 0, UINT32_MAX, Status::corrupt, "joints need more than");
  lie("joints", 112 + 8, std::uint32_t(1), Status::corrupt, "has the number 1 and its parent 1");
  lie("skin", 0, std::uint32_t(0), Status::corrupt, "influences are not 1 to 32");
  lie("skin", 0, std::uint32_t(33), Status::corrupt, "influences are not 1 to 32");
  lie("skin", 4, std::uint8_t(3), Status::corrupt, "more influences than all");
  lie("skin", 4, std::uint8_t(2), Status::corrupt, "section \"skin\"");
  lie("skin", 34, std::uint16_t(3), Status::corrupt, "vertex 0 follows joint 3 of 3");
  lie("skin", 34 + 60 + 90, std::uint8_t(0), Status::corrupt, "weights of joints that sum to");
  lie("skin", 34 + 60 + 90, std::uint8_t(0xbf), Status::corrupt, "not above 0");
  // How many outer rotations the first driven joint has, and how many the last.
  constexpr std::size_t outer = 4 + 4 + 3 + 4 + 2, outer_of_last = outer + 3 * (4 + 4 + 2 + 1 + 48) + 6 + 3 + 3;
  lie("driven-joints", outer_of_last + 2, std::uint8_t(8), Status::corrupt, "outer rotation with the numbers 0x8");
  lie("driven-joints", outer, std::uint8_t(255), Status::corrupt, "section \"driven-joints\"");
  ArchiveEditor empty(bytes);
  empty["joints"].set(Bytes(4));
  check_refused(empty.bytes(), Status::corrupt, "there are no joints");
  ArchiveEditor alone(bytes);
  std::erase_if(alone.sections, [](const auto& section) { return section.name == "joints"; });
  check_refused(alone.bytes(), Status::corrupt, "vertex 0 follows joint 1 of 0");
}

TEST_CASE("joints and skins that are cut short, too long or changed never crash the reader") {
  for (const std::string name : {"joints", "skin", "driven-joints"}) {
    INFO(name);
    ArchiveEditor archive(write_archive(name == "driven-joints" ? driven_model() : body_model(), {}));
    const Bytes contents = archive[name].stored;
    for (std::size_t size = 0; size < contents.size(); ++size) {
      archive[name].set({contents.begin(), contents.begin() + std::ptrdiff_t(size)});
      REQUIRE(outcome(archive.bytes()).status == Status::corrupt);
    }
    Bytes longer = contents;
    longer.push_back(std::byte(0));
    archive[name].set(longer);
    check_refused(archive.bytes(), Status::corrupt, "should end here");
    archive[name].set(contents);
    for (std::byte& byte : archive[name].stored)
      for (const int mask : {0x01, 0x80, 0xff}) {
        byte ^= std::byte(mask);
        const Outcome seen = outcome(archive.bytes(), {std::uint64_t(1) << 24});
        REQUIRE((seen.status == Status::ok || !seen.message.empty()));
        byte ^= std::byte(mask);
      }
  }
}

TEST_CASE("names of joints and what skins take count towards the limits") {
  PackedModel model = body_model();
  model.character.joints[1].name = std::string(2000, 'j');
  ReadLimits limits;
  limits.max_name_bytes = 1900;
  check_refused(write_archive(model, {}), Status::limit, "bytes of names and texts", limits);
  // Thirty vertices of one influence each, said to have 32: that much is charged before it is allocated.
  ArchiveEditor archive(write_archive(body_model(), {}));
  MemoryBudget narrow, wide;
  read_archive(archive.bytes(), {}, Parts::all, narrow);
  Bytes contents = archive["skin"].stored;
  patch(contents, 0, std::uint32_t(32));
  archive["skin"].set(contents);
  read_archive(archive.bytes(), {}, Parts::all, wide);
  CHECK(wide.used() >= narrow.used() + 30 * 30 * (sizeof(float) + sizeof(std::uint16_t)));
}

}  // namespace
}  // namespace fb::test_joints

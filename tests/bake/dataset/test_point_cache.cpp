#include "bake/dataset/point_cache.h"

#include <bit>
#include <cstring>
#include <fstream>

#include "bake/dataset/dataset_index.h"
#include "toy_dataset.h"

namespace test_point_cache {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;
using namespace fb::test::toy_dataset;

namespace {

// A file's bytes, number after number.
class Bytes {
 public:
  Bytes& text(const char* letters, std::size_t count) {
    bytes_.append(letters, count);
    return *this;
  }
  Bytes& big(std::uint32_t value) { return little(__builtin_bswap32(value)); }
  Bytes& little(std::uint32_t value) {
    char four[4];
    std::memcpy(four, &value, 4);
    bytes_.append(four, 4);
    return *this;
  }
  Bytes& big(float value) { return big(std::bit_cast<std::uint32_t>(value)); }
  Bytes& little(float value) { return little(std::bit_cast<std::uint32_t>(value)); }
  const std::string& all() const { return bytes_; }

 private:
  std::string bytes_;
};

std::string mdd(std::uint32_t frame_count, std::uint32_t points, const std::vector<float>& positions) {
  Bytes bytes;
  bytes.big(frame_count).big(points);
  for (std::uint32_t f = 0; f < frame_count; ++f) bytes.big(static_cast<float>(f) / 24);
  for (const float position : positions) bytes.big(position);
  return bytes.all();
}

std::string pc2(std::uint32_t samples, std::uint32_t points, const std::vector<float>& positions) {
  Bytes bytes;
  bytes.text("POINTCACHE2\0", 12).little(1u).little(points).little(0.0f).little(1.0f).little(samples);
  for (const float position : positions) bytes.little(position);
  return bytes.all();
}

void put(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace

TEST_CASE("MDD and PC2 caches are points of a clip, whole and in shards") {
  ToyDataset toy;
  const std::vector<float> all = counting(frames * 12, 0.5f);
  const std::vector<float> first(all.begin(), all.begin() + 24), rest(all.begin() + 24, all.end());
  std::filesystem::remove(toy.folder / "talk.points.npy");
  std::filesystem::remove(toy.folder / "walk.points.npy");
  put(toy.folder / "talk.mdd", mdd(frames, vertices, all));
  put(toy.folder / "walk.000.points.pc2", pc2(2, vertices, first));
  put(toy.folder / "walk.001.points.pc2", pc2(4, vertices, rest));
  toy.replace("talk.points.npy", "talk.mdd");
  toy.replace("walk.points.npy", "walk.points.pc2");
  const auto source = toy.open();
  std::vector<float> points(frames * 12), middle(3 * 12);
  for (const std::size_t clip : {0, 1}) {
    source->read(clip, 0, frames, points);
    CHECK(points == all);
    source->read(clip, 1, 3, middle);
    CHECK(middle == std::vector<float>(all.begin() + 12, all.begin() + 48));
  }
}

TEST_CASE("shards of caches are numbered before the extension") {
  CHECK(shard_name("walk.mdd", 3) == "walk.003.mdd");
  CHECK(shard_name("walk.points.mdd", 12) == "walk.012.points.mdd");
  CHECK(shard_name("walk.pc2", 0) == "walk.000.pc2");
  CHECK(shard_name("walk.points.npy", 0) == "walk.000.points.npy");
}

TEST_CASE("caches whose headers do not tell the truth are refused") {
  const Folder folder;
  const std::vector<float> positions = counting(2 * 12, 0.5f);
  const auto refused = [&](const char* name, const std::string& bytes, const char* message,
                           Status status = Status::bad_data) {
    CAPTURE(message);
    put(folder / name, bytes);
    const std::string what = failure(status, [&] { open_array(folder / name); });
    CHECK_MESSAGE(contains(what, message), what);
    CHECK_MESSAGE(contains(what, name), what);
  };
  const std::string good_mdd = mdd(2, 4, positions), good_pc2 = pc2(2, 4, positions);
  for (std::size_t length = 0; length < good_mdd.size(); ++length)
    refused("a.mdd", good_mdd.substr(0, length), length < 8 ? "no whole header" : "is truncated");
  for (std::size_t length = 0; length < good_pc2.size(); ++length)
    refused("a.pc2", good_pc2.substr(0, length), length < 32 ? "no whole header" : "is truncated");
  refused("a.mdd", good_mdd + "x", "is 1 bytes longer than shape (2, 4, 3) needs");
  refused("a.pc2", good_pc2 + "x", "is 1 bytes longer");
  refused("a.mdd", mdd(0, 4, {}), "its header says 0 frames");
  refused("a.mdd", mdd(2, 0, {}), "its header says 0 points");
  refused("a.mdd", Bytes().big(0xffffffffu).big(4u).all(), "its header says -1 frames");
  refused("a.mdd", Bytes().big(0x7fffffffu).big(4u).all(), "is truncated");
  refused("a.mdd", Bytes().big(0x7fffffffu).big(0x7fffffffu).all(), "overflows", Status::limit);
  refused("a.pc2", pc2(0, 4, {}), "its header says 0 samples");
  refused("a.pc2", pc2(2, 0, {}), "its header says 0 points");
  refused("a.pc2", "POINTCACHE1" + good_pc2.substr(11), "does not begin with POINTCACHE2");
  std::string newer = good_pc2;
  newer[12] = 2;
  refused("a.pc2", newer, "PC2 version 2", Status::unsupported);
  failure(Status::not_found, [&] { open_array(folder / "none.mdd"); });
}

TEST_CASE("a cache of another mesh is refused by shape") {
  ToyDataset toy;
  put(toy.folder / "talk.mdd", mdd(frames, 5, counting(frames * 15, 0.5f)));
  toy.replace("talk.points.npy", "talk.mdd");
  const std::string what = failure(Status::bad_data, [&] { toy.open(); });
  CHECK_MESSAGE(contains(what, "talk.mdd: shape (6, 5, 3) where (frames, 4, 3) is needed"), what);
}

}  // namespace test_point_cache

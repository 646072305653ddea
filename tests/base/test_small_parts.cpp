// The small parts of base: random numbers, hashes, checked sizes, formatted failures, progress.
#include <doctest/doctest.h>

#include <atomic>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <string>
#include <thread>

#include "base/checked.h"
#include "base/decimal_points.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/json_depth.h"
#include "base/keep_asking.h"
#include "base/length_units.h"
#include "base/match_names.h"
#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/random.h"
#include "base/sha256.h"
#include "base/shown_path.h"
#include "base/small_blocks.h"
#include "base/status.h"
#include "base/utf8.h"
#include "base/visible_text.h"
#include "temporary_folder.h"
#include "watched_progress.h"

namespace fb::test_small_parts {

TEST_CASE("lengths are told in millimetres, or in a unit that nobody knows") {
  CHECK(metres_per("inch").value() == doctest::Approx(0.0254));
  CHECK(metres_per("in").value() == doctest::Approx(0.0254));
  CHECK(metres_per("ft").value() == doctest::Approx(0.3048));
  CHECK_FALSE(metres_per("head").has_value());
  CHECK_FALSE(metres_per("").has_value());
  CHECK(length_text(0.256, "cm") == "2.56 mm");
  CHECK(length_text(0.0125, "m") == "12.5 mm");
  CHECK(length_text(3, "mm") == "3 mm");
  CHECK(length_text(0.25, "head") == "0.25 head");
  CHECK(unusual_size_text(38.7, "cm").empty());
  CHECK(unusual_size_text(2.1, "m").empty());
  CHECK(unusual_size_text(155, "").empty());
  CHECK(unusual_size_text(155, "m").find("155 m large") != std::string::npos);
  CHECK(unusual_size_text(0.2, "cm").find("0.002 m large") != std::string::npos);
  CHECK(length_text(0.25, "") == "0.25");
}

TEST_CASE("a seed always gives the same numbers") {
  Random random(1, 2);
  CHECK(random.next() == 5948053812914333585u);
  CHECK(random.next() == 10371359604880545516u);
  CHECK(Random(1, 2).next() != Random(1, 3).next());
  CHECK(Random(1, 2).next() != Random(2, 2).next());
}

TEST_CASE("random numbers keep their range and their moments") {
  Random random(42);
  double sum = 0, squares = 0, normal = 0, normal_squares = 0;
  int hits[5] = {};
  const int count = 20000;
  for (int i = 0; i < count; ++i) {
    const float u = random.uniform();
    REQUIRE(u >= 0);
    REQUIRE(u < 1);
    sum += u;
    squares += u * u;
    const float v = random.uniform(-3, -1);
    REQUIRE(v >= -3);
    REQUIRE(v <= -1);
    const std::uint32_t k = random.below(5);
    REQUIRE(k < 5);
    ++hits[k];
    const float n = random.normal();
    normal += n;
    normal_squares += n * n;
  }
  CHECK(std::fabs(sum / count - 0.5) < 0.01);
  CHECK(std::fabs(squares / count - 1.0 / 3) < 0.01);
  CHECK(std::fabs(normal / count) < 0.03);
  CHECK(std::fabs(normal_squares / count - 1) < 0.03);
  for (const int h : hits) CHECK(std::abs(h - count / 5) < count / 50);
}

TEST_CASE("hash64 is XXH64") {
  CHECK(hash64({}) == 0xef46db3751d8e999u);
  const std::string text = "abc";
  CHECK(hash64(std::as_bytes(std::span(text))) == 0x44bc2cf5ad770999u);
  CHECK(hash64(std::as_bytes(std::span(text)), 1) != 0x44bc2cf5ad770999u);
}

TEST_CASE("sha256_of_file is SHA-256") {
  const test::Folder folder;
  const auto hash = [&](const std::string& text) {
    write_file(folder / "file", text);
    return sha256_of_file(folder / "file");
  };
  CHECK(hash("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(hash("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(hash("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(hash(std::string(1000000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  CHECK(hash(std::string(std::size_t{1} << 20, '\0')) ==
        "30e14955ebf1352266dc2ff8067e68104607e750abb9d3b36582b8af909fcb58");
}

TEST_CASE("texts that are no UTF-8 are found, and where") {
  for (const char* text :
       {"", "plain", "\xc2\x80 \xdf\xbf", "\xe0\xa0\x80\xed\x9f\xbf\xee\x80\x80", "\xf0\x90\x80\x80\xf4\x8f\xbf\xbf"})
    CHECK(!find_utf8_fault(text));
  CHECK(find_utf8_fault(std::string_view("ab\0", 3)) == 2);
  for (const char* fault : {"\x80", "\xc0\x80", "\xc1\xbf", "\xc2", "\xc2z", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xef\xbf",
                            "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff"})
    CHECK_MESSAGE(find_utf8_fault(std::string("ok") + fault) == 2, fault);
}

TEST_CASE("names are matched exactly if they can be, else by letters and sides") {
  const std::vector<std::vector<std::string>> things = {{"jaw", "JawOpen"}, {"jawopen"}, {"smile_L", ""}, {"--"}};
  const auto match = [&](const char* name) { return match_names({name}, things)[0]; };
  CHECK(match("JawOpen") == 0);
  CHECK(match("jawopen") == 1);
  CHECK(match("JAW_OPEN") == 1);
  CHECK(match("Smile Left") == 2);
  CHECK(match("smileRight") == std::nullopt);
  CHECK(match("--") == 3);
  CHECK(match("...") == std::nullopt);
  CHECK(match("") == std::nullopt);
  CHECK(match_names({}, things).empty());
}

TEST_CASE("a mistyped word means the nearest name") {
  const std::vector<std::string> names = {"sample", "plan", "bake", "help"};
  CHECK(fb::nearest_name("sampel", names) == "sample");  // neighbours swapped: one edit
  CHECK(fb::nearest_name("smple", names) == "sample");
  CHECK(fb::nearest_name("baake", names) == "bake");
  CHECK(fb::nearest_name("bkae", names) == "bake");
  CHECK(fb::nearest_name("exmaples", names) == std::nullopt);
  CHECK(fb::nearest_name("", names) == std::nullopt);
  CHECK(fb::nearest_name(std::string(100, 'a'), {std::string(100, 'a')}) == std::nullopt);
}

TEST_CASE("sizes that overflow fail instead of wrapping") {
  CHECK(checked_multiply(3, 4, "x") == 12);
  CHECK(checked_multiply(SIZE_MAX, 1, "x") == SIZE_MAX);
  CHECK_THROWS_WITH_AS(checked_multiply(SIZE_MAX, 2, "weights"), doctest::Contains("weights"), Error);
  CHECK(checked_add(SIZE_MAX - 1, 1, "x") == SIZE_MAX);
  CHECK_THROWS_WITH_AS(checked_add(SIZE_MAX, 1, "weights"), doctest::Contains("weights"), Error);
  CHECK(checked_u32(UINT32_MAX, "x") == UINT32_MAX);
  CHECK_THROWS_WITH_AS(checked_u32(std::size_t(1) << 32, "corners"), doctest::Contains("corners"), Error);
}

TEST_CASE("failures carry a status and a message of any length") {
  try {
    fail(Status::rig, "control %d: %s", 7, std::string(3000, 'x').c_str());
  } catch (const Error& error) {
    CHECK(error.status() == Status::rig);
    CHECK(error.what() == "control 7: " + std::string(3000, 'x'));
  }
  CHECK(format("%s", "").empty());
}

TEST_CASE("progress forwards steps and throws when cancelled") {
  struct Recorder : test::QuietProgress {
    std::uint64_t last = 0, stop_at = 3;
    void update(std::uint64_t done) override { last = done; }
    bool cancelled() const override { return last >= stop_at; }
  } recorder;
  recorder.step(2);
  CHECK(recorder.last == 2);
  try {
    recorder.step(3);
    FAIL("was not interrupted");
  } catch (const Error& error) {
    CHECK(error.status() == Status::interrupted);
  }
  silent_progress().begin(Phase::writing, "anything", 1);
  CHECK_FALSE(silent_progress().cancelled());
}

TEST_CASE("progress is asked while work goes on that cannot ask, and waits for its end") {
  test::Questions progress;
  const int result = ask_during(progress, [&] {
    while (progress.asked < 3) std::this_thread::yield();  // for ever if nobody asked
    return 42;
  });
  CHECK(result == 42);
  CHECK_THROWS_WITH_AS(keep_asking(progress, [] { fail(Status::rig, "broken"); }), "broken", Error);
  bool ended = false;
  try {
    keep_asking(progress, [&] {
      const int before = progress.asked;
      progress.stop_at = before;
      while (progress.asked == before) std::this_thread::yield();
      ended = true;
    });
    FAIL("it was not interrupted");
  } catch (const Error& error) {
    CHECK(error.status() == Status::interrupted);
  }
  CHECK(ended);
}

TEST_CASE("the depth of JSON is counted outside of strings") {
  const auto nested = [](std::size_t levels) { return std::string(levels, '[') + std::string(levels, ']'); };
  check_json_depth(nested(most_json_levels) + nested(most_json_levels));
  const auto joined = [](std::initializer_list<std::string> parts) {
    std::string text;
    for (const std::string& part : parts) text += part;
    return text;
  };
  check_json_depth(joined({"\"", nested(1000), "\\\"", nested(1000), "\\\\\""}));
  check_json_depth(joined({"]]]]", nested(most_json_levels)}));
  CHECK_THROWS_AS(check_json_depth(nested(most_json_levels + 1)), Error);
  CHECK_THROWS_AS(check_json_depth(joined({"{\"a\\\\\":", nested(most_json_levels), "}"})), Error);
}

TEST_CASE("long texts and paths are shortened in their middle, between characters") {
  CHECK(shown(std::string(240, 'a')) == std::string(240, 'a'));
  CHECK(shown(std::string(241, 'a')).size() == 240);
  std::string umlauts;
  for (int i = 0; i < 1000; ++i) umlauts += "\xc3\xa4";
  for (const std::string& text : {umlauts, "x" + umlauts}) {
    const std::string short_text = shown(text);
    CHECK(short_text.size() <= 240);
    CHECK(short_text.size() > 230);
    const std::size_t dots = short_text.find("...");
    CHECK(short_text.substr(dots - 2, 7) == "\xc3\xa4...\xc3\xa4");
  }
  CHECK_THROWS_WITH_AS(with_path("/f", [] { fail(Status::io, "broken"); }), "broken (/f)", Error);
  CHECK_THROWS_WITH_AS(with_path("/f", [] { fail_on("/f", Status::io, "broken"); }), "broken (/f)", Error);
}

TEST_CASE("what commands a terminal becomes visible") {
  const auto hidden = [](std::string_view text) { return visible_text(text, Layout::hidden); };
  CHECK(hidden("gr\xc3\xb6\xc3\x9f"
               "e \xf0\x9f\x98\x80 a\\b") ==
        "gr\xc3\xb6\xc3\x9f"
        "e \xf0\x9f\x98\x80 a\\b");
  CHECK(hidden("\033]0;x\007\177") == "\\u001b]0;x\\u0007\\u007f");
  CHECK(hidden("\xc2\x9b"
               "31m") == "\\u009b31m");  // in one character
  CHECK(hidden("a\xe2\x80\xae"
               "b\xe2\x81\xa6"
               "c") == "a\\u202eb\\u2066c");  // from right to left
  CHECK(hidden("a\nb\tc\r") == "a\\u000ab\\u0009c\\u000d");
  CHECK(visible_text("a\nb\tc\r", Layout::kept) == "a\nb\tc\\u000d");
  CHECK(hidden("\xff\xc3") == "\\xff\\xc3");
  CHECK(hidden(std::string_view("a\0b", 3)) == "a\\x00b");
  CHECK(shown("\033[31m") == "\\u001b[31m");
  char room[8];
  CHECK(write_visible_text("abcdef\033", Layout::hidden, room) == 6);  // whole characters alone
}

TEST_CASE("numbers have decimal points whatever locale a host has set") {
  const test::Folder folder;
  const std::string made = "localedef -i de_DE -f UTF-8 " + (folder / "de_DE.UTF-8").string() + " >/dev/null 2>&1";
  setenv("LOCPATH", folder.path().c_str(), 1);
  if (std::system(made.c_str()) < 0 || !std::setlocale(LC_ALL, "de_DE.UTF-8")) {
    MESSAGE("skipped: there is no German locale (Debian: locales)");
  } else {
    CHECK(std::to_string(0.5) == "0,500000");  // as C prints it
    CHECK(format("%.1f of %g", 0.5, 1e-3) == "0.5 of 0.001");
    CHECK_THROWS_WITH_AS(fail(Status::rig, "%.2f", 2.25), "2.25", Error);
    {
      const DecimalPoints decimal_points;
      CHECK(std::strtod("1.5", nullptr) == 1.5);
    }
    CHECK(std::strtod("1,5", nullptr) == 1.5);  // the host's again
  }
  std::setlocale(LC_ALL, "C");
  unsetenv("LOCPATH");
}

TEST_CASE("a budget counts what is in use, and refuses what exceeds it") {
  MemoryBudget budget(100000);
  {
    const std::pmr::vector<std::uint32_t> numbers(10000, &budget);
    CHECK(budget.used() >= 40000);
    CHECK_THROWS_AS(std::pmr::vector<std::uint32_t>(20000, &budget), Error);
    const ScopedCharge charge(budget, 1000, 8, "marks");
    CHECK(budget.used() >= 48000);
    ChargedMemory other(*std::pmr::new_delete_resource(), budget);
    const std::pmr::vector<std::byte> bytes(30000, &other);
    CHECK_THROWS_WITH_AS(budget.take(UINT64_MAX, 8, "names"), doctest::Contains("names: "), Error);
    CHECK(budget.used() <= 100000);
  }
  CHECK(budget.used() == 0);
  CHECK(budget.peak() >= 78000);
  std::pmr::vector<float> here;
  budget.resize(here, 100, "here");
  CHECK(here.size() == 100);
  budget.give_back(budget.used());
  std::vector<float> kept;
  budget.resize(kept, 1000, "kept");
  budget.take_text(3, "short");
  CHECK(kept.size() == 1000);
  CHECK(budget.used() >= 4000);
  CHECK(budget.used() < 4100);
}

// Counts what is asked of it.
class Counted final : public std::pmr::memory_resource {
 public:
  std::size_t calls = 0, bytes = 0;

 private:
  void* do_allocate(std::size_t size, std::size_t alignment) override {
    ++calls;
    bytes += size;
    return std::pmr::new_delete_resource()->allocate(size, alignment);
  }
  void do_deallocate(void* memory, std::size_t size, std::size_t alignment) override {
    bytes -= size;
    std::pmr::new_delete_resource()->deallocate(memory, size, alignment);
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }
};

TEST_CASE("small blocks come from few chunks, which go back when they are empty") {
  Counted upstream;
  SmallBlocks blocks(upstream);
  struct Block {
    std::byte* memory;
    std::size_t size, alignment;
  };
  std::vector<Block> held;
  Random random(3);
  std::size_t made = 0;
  for (int round = 0; round < 20000; ++round) {
    if (held.size() < 500 && random.uniform() < 0.6f) {
      const std::size_t size = random.below(round % 50 == 0 ? 40000 : 300), alignment = std::size_t(1)
                                                                                        << random.below(8);
      auto* const memory = static_cast<std::byte*>(blocks.allocate(size, alignment));
      CHECK(reinterpret_cast<std::uintptr_t>(memory) % alignment == 0);
      std::fill_n(memory, size, std::byte(held.size()));
      held.push_back({memory, size, alignment});
      ++made;
    } else if (!held.empty()) {
      const std::size_t i = random.below(static_cast<std::uint32_t>(held.size()));
      std::swap(held[i], held.back());
      const Block block = held.back();
      held.pop_back();
      for (std::size_t b = 1; b < block.size; ++b) REQUIRE(block.memory[b] == block.memory[0]);
      blocks.deallocate(block.memory, block.size, block.alignment);
    }
  }
  for (const Block& block : held) blocks.deallocate(block.memory, block.size, block.alignment);
  CHECK(upstream.bytes == 0);
  CHECK(made > 9000);
  CHECK(upstream.calls < made / 4);
}

}  // namespace fb::test_small_parts

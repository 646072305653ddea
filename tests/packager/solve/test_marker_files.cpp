// Captured markers in .trc and .csv files, good and bad.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "base/file.h"
#include "base/status.h"
#include "solve/marker_file.h"
#include "temporary_folder.h"

using namespace fb;
using namespace fb::tool;

namespace test_marker_files {

MarkerTake read(const std::string& text, const char* name) {
  const test::Folder folder;
  write_file(folder / name, text);
  return read_marker_file(folder / name);
}

// What is wrong with a file, without the folder it is in; "" where nothing is.
std::string fault(const std::string& text, const char* name) {
  const test::Folder folder;
  write_file(folder / name, text);
  try {
    read_marker_file(folder / name);
    return "";
  } catch (const Error& error) {
    std::string message = error.what();
    const std::string path = (folder.path() / "").string();
    for (std::size_t at = message.find(path); at != std::string::npos; at = message.find(path))
      message.erase(at, path.size());
    return message;
  }
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), by);
}

const std::string trc =
    "PathFileType\t4\t(X/Y/Z)\ttake.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "120.00\t120.00\t3\t2\tmm\t120.00\t1\t3\n"
    "Frame#\tTime\tsourcil gauche\xc3\xa9\t\t\tjaw\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
    "\n"
    "1\t0.000\t1.5\t-2\t3e1\t4\t5\t6\n"
    "2\t0.008\t\t\t\t4\t5\t6.25E-01\n"
    "3\t0.017\t1\t2\t3\n";

TEST_CASE("a .trc file is read, with missing markers") {
  const MarkerTake take = read(trc, "take.trc");
  CHECK(take.names == std::vector<std::string>{"sourcil gauche\xc3\xa9", "jaw"});
  CHECK(take.frames_per_second == 120);
  CHECK(take.metres_per_unit == 0.001);
  REQUIRE(take.frames == 3);
  CHECK(take.missing == std::vector<std::uint8_t>{0, 0, 1, 0, 0, 1});
  CHECK(take.positions == std::vector<float>{1.5f, -2, 30, 4, 5, 6, 0, 0, 0, 4, 5, 0.625f, 1, 2, 3, 0, 0, 0});
  CHECK(take.positions_of(1)[5] == 0.625f);
  CHECK(take.missing_of(2)[1] == 1);
  CHECK(take.notes.empty());
}

TEST_CASE("a .trc file may be as other programs write it") {
  std::string windows;
  for (const char c : trc) windows += c == '\n' ? "\r\n" : std::string(1, c);
  CHECK(read("\xef\xbb\xbf" + windows, "take.TRC").positions == read(trc, "take.trc").positions);
  // No empty line, fields of the older kind in another order, names without empty cells between them, cells at ends.
  const MarkerTake other = read(
      "PathFileType\t3\t(X/Y/Z)\ta\n"
      "NumMarkers\tUnits\tDataRate\n2\tMeters\t59.94\n"
      "Frame#\tTime\ta\tb\t\n"
      "\t\tX5\tY5\tZ5\tX6\tY6\tZ6\t\n"
      "100\t0\tNaN\tnan\tNAN\t+1\t2\t3\t\t\n"
      "101\t0.02\t1\t2\t3\t0\t0\t0.0\n"
      "\n\n",
      "take.trc");
  CHECK(other.frames_per_second == 59.94);
  CHECK(other.metres_per_unit == 1);
  CHECK(other.missing == std::vector<std::uint8_t>{1, 0, 0, 1});
  REQUIRE(other.notes.size() == 1);
  CHECK(other.notes[0] == "1 positions are 0, 0, 0, as some programs write missing markers: they are left out");
}

TEST_CASE("what is odd about a .trc file is told") {
  const MarkerTake take =
      read(replaced(replaced(trc, "\t3\t2\tmm", "\t300\t2\tmm"), "\n3\t0.017", "\n7\t0.017"), "t.trc");
  REQUIRE(take.notes.size() == 2);
  CHECK(take.notes[0] == "after frame 2 comes frame 7: frames are taken one after the other");
  CHECK(take.notes[1] == "NumFrames says 300 frames, and there are 3");
  const MarkerTake unseen = read(replaced(replaced(trc, "4\t5\t6\n", "\t\t\n"), "4\t5\t6.25E-01", "\t\t"), "t.trc");
  REQUIRE(unseen.notes.size() == 1);
  CHECK(unseen.notes[0] == "the marker \"jaw\" is in no frame");
}

TEST_CASE("a bad .trc file is refused with the place and the reason") {
  const auto bad = [&](const std::string& what, const std::string& by) {
    return fault(replaced(trc, what, by), "t.trc");
  };
  CHECK(fault("", "t.trc") == "t.trc, line 0: this is no .trc file: it begins with no PathFileType");
  CHECK(fault("time,a.x\n", "t.trc") == "t.trc, line 1: this is no .trc file: it begins with no PathFileType");
  CHECK(bad("Units", "Unit").find("t.trc, line 3: there is no Units: lines 2 and 3 have") == 0);
  CHECK(bad("120.00", "fast") == "t.trc, line 3: DataRate is \"fast\", no number of frames per second");
  CHECK(bad("120.00", "0") == "t.trc, line 3: DataRate is \"0\", no number of frames per second");
  CHECK(bad("\t2\tmm", "\t-2\tmm") == "t.trc, line 3: NumMarkers is \"-2\", no number of markers");
  CHECK(bad("\tmm", "\tfurlong").find("t.trc, line 3: Units is \"furlong\"; it is mm") == 0);
  CHECK(bad("Frame#\tTime", "Frame# Time") ==
        "t.trc, line 4: line 4 does not begin with Frame# and Time, separated by a tab");
  CHECK(bad("\t2\tmm", "\t3\tmm") == "t.trc, line 4: 2 markers are named, while NumMarkers says 3");
  CHECK(bad("jaw", "sourcil gauche\xc3\xa9") ==
        "t.trc, line 4: markers 1 and 2 are both named \"sourcil gauche\xc3\xa9\"");
  CHECK(bad("\xc3\xa9", "\xc3").find("t.trc, line 4: the name of marker 1, ") == 0);
  CHECK(bad("\n2\t0.008", "\ntwo\t0.008") == "t.trc, line 8: \"two\" is no number of a frame");
  CHECK(bad("-2", "left") ==
        "t.trc, line 7, frame 1, marker \"sourcil gauche\xc3\xa9\": column 4: \"left\" is no number");
  CHECK(bad("6.25E-01", "inf") == "t.trc, line 8, frame 2, marker \"jaw\": column 8: \"inf\" is no position");
  CHECK(
      bad("6.25E-01", "") ==
      "t.trc, line 8, frame 2, marker \"jaw\": column 8, z, is empty while others are not: leave all three empty where "
      "it is missing");
  CHECK(bad("6.25E-01", "9999999")
            .find("t.trc, line 8, frame 2, marker \"jaw\": column 8: 9999999 is more than a kilo") == 0);
  CHECK(bad("6.25E-01", "1\t2") == "t.trc, line 8: frame 2 has 9 cells, while 2 markers have 8");
  CHECK(fault(trc.substr(0, trc.find("\n1\t") + 1), "t.trc") == "t.trc: no frames");
  CHECK(fault(trc.substr(0, trc.find("\n\t\tX1") + 1), "t.trc") == "t.trc, line 4: the file ends before its frames");
  CHECK(fault(trc, "t.c3d") == "t.c3d: captured markers are read from .trc and .csv files");
}

const std::string csv =
    "frame,time,brow.x,brow.y,brow.z,jaw:X,jaw:Y,jaw:Z\n"
    "0,0.0,1,2,3,4,5,6\n"
    "1,0.04,,,,4.5,5,6e0\n"
    "2,0.08,1,2,3,0,0,0\n";

TEST_CASE("a table of markers is read") {
  const MarkerTake take = read(csv, "take.csv");
  CHECK(take.names == std::vector<std::string>{"brow", "jaw"});
  CHECK(take.frames_per_second == doctest::Approx(25));
  CHECK_FALSE(take.metres_per_unit);
  CHECK(take.missing == std::vector<std::uint8_t>{0, 0, 1, 0, 0, 1});
  CHECK(take.positions == std::vector<float>{1, 2, 3, 4, 5, 6, 0, 0, 0, 4.5f, 5, 6, 1, 2, 3, 0, 0, 0});
  const MarkerTake semicolons = read("time;a_z;a_x;a_y\n0;3,5;1,25;2\n", "take.csv");
  CHECK(semicolons.positions == std::vector<float>{1.25f, 2, 3.5f});
  CHECK(semicolons.frames_per_second == 0);
}

TEST_CASE("a bad table of markers is refused with the place and the reason") {
  const auto bad = [&](const std::string& what, const std::string& by) {
    return fault(replaced(csv, what, by), "t.csv");
  };
  CHECK(bad("time", "t") ==
        "t.csv, line 1: column 2 is \"t\": columns are \"time\", \"frame\" and NAME.x, NAME.y, NAME.z");
  CHECK(bad("frame,time", "frame,frame") == "t.csv, line 1: there is no column \"time\"");
  CHECK(bad("frame,time", "time,time") == "t.csv, line 1: columns 1 and 2 are both \"time\"");
  CHECK(bad("brow.z", "brow.x") == "t.csv, line 1: columns 3 and 5 are both the x of \"brow\"");
  CHECK(bad("brow.z", "bro.z") == "t.csv, line 1: the marker \"brow\" has no column for its z");
  CHECK(fault("time\n0\n", "t.csv") == "t.csv, line 1: no markers are named");
  CHECK(bad("0.04", "soon") == "t.csv, line 3: the time is \"soon\", no number of seconds");
  CHECK(bad("0.04", "nan") == "t.csv, line 3: the time is \"nan\", no number of seconds");
  CHECK(bad("0.08", "0.8")
            .find("t.csv, line 3: the time goes from 0 to 0.04 s, while all frames together have steps "
                  "of 0.4 s") == 0);
  CHECK(bad("4.5", "x") == "t.csv, line 3, frame 2, marker \"jaw\": column 6: \"x\" is no number");
  CHECK(bad("4.5", "-inf") == "t.csv, line 3, frame 2, marker \"jaw\": column 6: \"-inf\" is no position");
  CHECK(bad("4.5", "") ==
        "t.csv, line 3, frame 2, marker \"jaw\": column 6, x, is empty while others are not: leave all "
        "three empty where it is missing");
  CHECK(bad(",6e0", "") == "t.csv, line 3: 7 cells where the first line names 8");
  CHECK(fault("time,a.x,a.y,a.z\n", "t.csv") == "t.csv: no frames");
}

TEST_CASE("markers and positions beyond the limits are refused") {
  std::string header = "time";
  for (int i = 0; i <= 4096; ++i)
    for (const char* axis : {".x", ".y", ".z"}) header += ",m" + std::to_string(i) + axis;
  CHECK(fault(header + "\n", "t.csv") == "t.csv, line 1: 4097 markers; at most 4096 are read");
}

}  // namespace test_marker_files

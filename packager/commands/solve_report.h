// The report of a solve: how near it came over time, where it did not, and pictures.
#pragma once

#include <filesystem>
#include <string>

#include "base/parallel.h"
#include "base/progress.h"
#include "commands/pose_evaluator.h"
#include "commands/solve_targets.h"
#include "solve/clip_solver.h"

namespace fb::tool {

// Figures of a solve as people and programs read them.
struct SolveFigures {
  SolveFigures(const facebaker::Model& model, const OpenedTarget& opened, const SolvedClip& clip);

  std::string text() const;  // a few lines
  std::string json() const;

  struct RegionFigures {
    std::string name;
    std::size_t points = 0;
    double rms = 0, max = 0;  // in units of the face
  };
  struct Undecided {
    std::string control;
    float decided = 0;
    double moved = 0;  // by how much of its range at most
  };
  std::string target, units;
  std::size_t frames = 0, points = 0, worst_frame = 0, measured = 0;
  double rms = 0, max = 0, p99 = 0, seconds = 0, iterations = 0;  // p99: of the frames' largest distances
  std::vector<RegionFigures> regions;                             // by largest rms; empty for faces without regions
  std::vector<Undecided> undecided;  // controls that move and are decided by less than half
  std::size_t moving = 0;            // controls that leave rest by more than a hundredth of their range
  std::vector<std::string> notes;
};

void write_solve_report(const std::filesystem::path& folder, const SolveFigures& figures, PoseEvaluator& evaluator,
                        const OpenedTarget& opened, const SolvedClip& clip, Progress& progress);

}  // namespace fb::tool

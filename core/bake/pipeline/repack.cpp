#include "bake/pipeline/repack.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/compress/step_scaling.h"
#include "bake/measure/certificate.h"
#include "bake/measure/keep_exact.h"
#include "bake/measure/verify.h"
#include "bake/rig/about.h"
#include "bake/rig/given_sockets.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr double uncertified_error = 0.01;  // over D
constexpr std::uint64_t candidates = 12;    // at most: two bisections of 41 factors

// Errors of a face whose vertices have moved since they were calibrated: in squares they add up.
ExpectedErrors with_more_error(const PackedModel& face, const Errors& displacement) {
  ExpectedErrors expected = face.expected;
  const double rms = displacement.rms * face.rest.diagonal() / expected.unit;
  for (ExpectedErrors::Region& region : expected.regions) region.constant += static_cast<float>(rms * rms);
  return expected;
}

// The archive with other steps. Each factor is packed and measured once.
class Repacker {
 public:
  Repacker(const archive::Archive& face, std::uint64_t seed, Progress& progress)
      : face_(&face), exact_(exact_frames(face.model)), seed_(seed), progress_(&progress) {
    poses_ = make_proof(face.model, seed).controls;
    const std::vector<float> more = make_proof(face.model, seed_of(seed, Stream::repacked_poses)).controls;
    poses_.insert(poses_.end(), more.begin(), more.end());
    progress.begin(Phase::packing, "repacking", candidates);
  }

  struct Candidate {
    StepScaling scaling;
    Errors displacement;
    std::vector<std::byte> archive;
  };

  const Candidate& at(double factor) {
    const auto known = candidates_.find(factor);
    if (known != candidates_.end()) return known->second;
    const Candidate& made = candidates_[factor] = make(factor);
    progress_->step(std::min<std::uint64_t>(candidates_.size(), candidates));
    return made;
  }

  MeasureScaling measure() {
    return [this](double factor) { return at(factor).scaling; };
  }

 private:
  Candidate make(double factor) const {
    Candidate made;
    archive::Archive scaled = *face_;
    if (factor > 1) {
      scaled.model = with_scaled_steps(face_->model, factor);
      if (!exact_.empty()) {
        keep_exact(scaled.model, exact_);
        add_exact_errors(scaled.text.certificate, exact_errors(scaled.model, exact_));
      }
      made.displacement = quantisation_errors(face_->model, scaled.model, poses_);
      add_requantisation_errors(scaled.text.certificate, made.displacement);
      scaled.model.expected = with_more_error(face_->model, made.displacement);
      scaled.proof = make_proof(scaled.model, seed_);
    }
    made.archive = archive::write_archive(scaled.model, scaled.proof, scaled.text);
    made.scaling = {factor, made.archive.size(), made.displacement.max};
    return made;
  }

  const archive::Archive* face_;
  const std::vector<ExactFrame> exact_;  // as the archive poses them
  std::uint64_t seed_;
  Progress* progress_;
  std::vector<float> poses_;
  std::map<double, Candidate> candidates_;
};

// `nearest`: what `force` would write. `allowed`: the fewest bytes within the error.
[[noreturn]] void refuse(const RepackOptions& options, double max_error, const StepScaling& nearest,
                         const StepScaling& allowed) {
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  const std::string reached =
      nearest.bytes > options.max_bytes
          ? format("the smallest there is has %llu bytes, with vertices displaced by up to %.3g of the diagonal",
                   number(nearest.bytes), nearest.error)
          : format("within them (%llu bytes) vertices are displaced by up to %.3g of the diagonal",
                   number(nearest.bytes), nearest.error);
  fail(Status::limit,
       "%llu bytes cannot be had: %s; allowed is a displacement of %.3g%s, for which it takes %llu bytes (displaced by "
       "up to %.3g). Allow more bytes or a larger error, or force it",
       number(options.max_bytes), reached.c_str(), max_error,
       options.max_error > 0 ? "" : " (by default, as far as the certified errors go)", number(allowed.bytes),
       allowed.error);
}

void replace_character(archive::Archive& face, const RepackOptions& options) {
  Character& character = face.model.character;
  if (!options.about.empty()) {
    character.about = merged_about(character.about, options.about);
    if (const std::string licence = take_licence(character.about); !licence.empty()) face.text.licence = licence;
  }
  if (!options.licence.empty()) face.text.licence = options.licence;
  if (!options.thumbnail.empty()) character.thumbnail = options.thumbnail;
  if (!options.sockets.empty()) {
    add_sockets(options.sockets, face.model.rest, character);
    face.proof = {};
  }
}

}  // namespace

double default_repack_error(const std::string& certificate) {
  const std::optional<CertifiedErrors> certified = certified_errors(certificate);
  return certified ? std::max(0.0, certified->largest - certified->repacked) : uncertified_error;
}

RepackResult repack(std::span<const std::byte> archive, const RepackOptions& options, Progress& progress) {
  if (!std::isfinite(options.max_error) || options.max_error < 0)
    fail(Status::invalid_argument, "max_error is %g; it is a fraction of the diagonal, 0 or more", options.max_error);
  archive::Archive face = archive::read_archive(archive);
  replace_character(face, options);
  if (face.proof.hashes.empty()) face.proof = make_proof(face.model, options.seed);
  RepackResult result;
  result.source_bytes = archive.size();
  result.source_version = face.format_version;
  if (options.max_bytes == 0 && options.max_error == 0) {
    result.archive = archive::write_archive(face.model, face.proof, face.text);
    result.bytes = result.archive.size();
    return result;
  }

  result.max_error = options.max_error > 0 ? options.max_error : default_repack_error(face.text.certificate);
  Repacker repacker(face, options.seed, progress);
  const StepScaling chosen = options.max_bytes > 0 ? finest_within_bytes(options.max_bytes, repacker.measure())
                                                   : coarsest_within_error(result.max_error, repacker.measure());
  result.within_limits =
      chosen.error <= result.max_error && (options.max_bytes == 0 || chosen.bytes <= options.max_bytes);
  if (!result.within_limits && !options.force)
    refuse(options, result.max_error, chosen, coarsest_within_error(result.max_error, repacker.measure()));
  const Repacker::Candidate& candidate = repacker.at(chosen.factor);
  result.archive = candidate.archive;
  result.bytes = chosen.bytes;
  result.factor = chosen.factor;
  result.displacement = candidate.displacement;
  progress.step(candidates);
  return result;
}

}  // namespace fb::bake

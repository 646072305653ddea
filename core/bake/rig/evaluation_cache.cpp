#include "bake/rig/evaluation_cache.h"

#include <algorithm>
#include <array>
#include <utility>

#include "bake/rig/content_hash.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using Header = std::array<std::uint64_t, 2>;                    // format, rig
constexpr std::uint64_t format_number = 0x3130'6c61'7665'6266;  // "fbeval01"

// Reads values from byte `offset` on, which moves behind them. False at the end of the file.
template <class Values>
bool read(const InputFile& file, std::uint64_t& offset, Values&& values) {
  const auto bytes = std::as_writable_bytes(std::span(values));
  offset += bytes.size();
  return file.read_at(offset - bytes.size(), bytes) == bytes.size();
}

template <class Values>
void write(std::ofstream& file, const Values& values) {
  const auto bytes = std::as_bytes(std::span(values));
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

EvaluationCache::EvaluationCache(std::filesystem::path path, const Source& rig)
    : path_(std::move(path)),
      rig_hash_(ContentHash().add(rig).value),
      width_(rig.schema().control_count()),
      size_(rig.rest().points.size()),
      found_(width_) {
  open_for_reading();
}

std::uint64_t EvaluationCache::record_bytes() const {
  return sizeof(std::uint64_t) + (width_ + size_) * sizeof(float);
}

std::uint64_t EvaluationCache::record_hash(std::span<const float> controls, std::span<const float> points) const {
  return hash64_of(points, hash64_of(controls));
}

void EvaluationCache::open_for_reading() {
  std::error_code error;
  if (!std::filesystem::exists(path_, error)) return;
  reading_.emplace(path_);
  Header header{};
  std::uint64_t offset = 0;
  if (!read(*reading_, offset, header) || header != Header{format_number, rig_hash_}) return reading_.reset();
  record_count_ = (reading_->size() - sizeof header) / record_bytes();
  for (std::uint64_t record = 0; record < record_count_; ++record) {
    offset = sizeof header + record * record_bytes() + sizeof(std::uint64_t);
    if (read(*reading_, offset, found_)) records_[hash64_of<float>(found_)] = record;
  }
}

bool EvaluationCache::find(std::span<const float> controls, std::span<float> points) {
  if (records_.empty()) return false;
  const auto known = records_.find(hash64_of(controls));
  if (known == records_.end()) return false;
  if (!reading_) reading_.emplace(path_);
  std::uint64_t hash = 0, offset = sizeof(Header) + known->second * record_bytes();
  const bool whole = read(*reading_, offset, std::span(&hash, 1)) && read(*reading_, offset, found_) &&
                     read(*reading_, offset, points) && hash == record_hash(found_, points);
  if (whole && std::equal(controls.begin(), controls.end(), found_.begin())) return true;
  if (!whole) records_.erase(known);
  return false;
}

void EvaluationCache::open_for_writing() {
  make_folder(path_.has_parent_path() ? path_.parent_path() : ".");
  const bool fresh = record_count_ == 0;
  if (!fresh) {
    std::error_code failed;
    std::filesystem::resize_file(path_, sizeof(Header) + record_count_ * record_bytes(), failed);
    if (failed) fail_writing();
  }
  writing_.open(path_, std::ios::binary | (fresh ? std::ios::trunc : std::ios::app));
  if (fresh) write(writing_, Header{format_number, rig_hash_});
}

void EvaluationCache::store(std::span<const float> controls, std::span<const float> points) {
  if (!writing_.is_open()) open_for_writing();
  const std::uint64_t hash = record_hash(controls, points);
  write(writing_, std::span(&hash, 1));
  write(writing_, controls);
  write(writing_, points);
  if (!writing_) fail_writing();
  records_[hash64_of(controls)] = record_count_++;
}

void EvaluationCache::flush() {
  if (writing_.is_open() && !writing_.flush()) fail_writing();
}

void EvaluationCache::fail_writing() const {
  fail(Status::io, "%s: the rig's evaluations cannot be written", shown(path_).c_str());
}

}  // namespace fb::bake

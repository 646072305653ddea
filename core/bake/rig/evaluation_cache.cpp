#include "bake/rig/evaluation_cache.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "base/file.h"
#include "base/hash.h"
#include "base/locked_file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::uint64_t format_number = 0x3230'6c61'7665'6266;  // "fbeval02"
constexpr std::uint64_t most_text = std::uint64_t{1} << 26;

// Then a text of so many bytes: the rig's identity.
struct Header {
  std::uint64_t format = format_number, hash = 0, text_bytes = 0;
};

struct RecordHeader {
  std::uint64_t hash = 0;
  EvaluationCache::Origin origin = EvaluationCache::Origin::evaluated;
};

std::uint64_t hash_of(const std::string& text) {
  return hash64_of(std::span<const char>(text));
}

// Reads values from byte `offset` on, which moves behind them. False at the end of the file.
template <class Values>
bool read_values(const InputFile& file, std::uint64_t& offset, Values&& values) {
  const auto bytes = std::as_writable_bytes(std::span(values));
  offset += bytes.size();
  return file.read_at(offset - bytes.size(), bytes) == bytes.size();
}

template <class Values>
void write(std::ofstream& file, const Values& values) {
  const auto bytes = std::as_bytes(std::span(values));
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// The system's reason for the last call that failed, after a stream did.
std::string reason_of_system() {
  return errno != 0 ? std::strerror(errno) : "the system gave no reason";
}

// Moves `offset` behind the header. Nothing where there is none, or a damaged one.
std::optional<RigIdentity> read_header(const InputFile& file, Header& header, std::uint64_t& offset) {
  if (!read_values(file, offset, std::span(&header, 1)) || header.format != format_number) return std::nullopt;
  if (header.text_bytes > std::min(most_text, file.size())) return std::nullopt;
  std::string text(header.text_bytes, ' ');
  if (!read_values(file, offset, text) || header.hash != hash_of(text)) return std::nullopt;
  return identity_from(text);
}

}  // namespace

EvaluationCache::EvaluationCache(std::filesystem::path path, RigIdentity rig)
    : path_(std::move(path)),
      rig_(std::move(rig)),
      width_(rig_.schema.control_count()),
      size_(3 * rig_.vertices),
      found_(width_) {
  open_for_reading();
}

std::optional<RigIdentity> EvaluationCache::rig_of(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  Header header;
  std::uint64_t offset = 0;
  return read_header(InputFile(path), header, offset);
}

std::uint64_t EvaluationCache::record_bytes() const {
  return sizeof(RecordHeader) + (width_ + size_) * sizeof(float);
}

std::uint64_t EvaluationCache::record_hash(Origin origin, std::span<const float> controls,
                                           std::span<const float> points) const {
  return hash64_of(points, hash64_of(controls, static_cast<std::uint64_t>(origin)));
}

void EvaluationCache::open_for_reading() {
  std::error_code error;
  if (!std::filesystem::exists(path_, error)) return;
  reading_.emplace(path_);
  Header header;
  const std::optional<RigIdentity> rig = read_header(*reading_, header, header_bytes_);
  if (!rig) return reading_.reset();
  const auto differs = difference(*rig, rig_);
  // Of another shape, records have another size.
  if (!differs) record_count_ = (reading_->size() - header_bytes_) / record_bytes();
  if (differs && reading_->size() > header_bytes_)
    fail(Status::invalid_argument,
         "%s: holds evaluations of another rig: %s. Bake into another folder; --reuse FOLDER, with the folder of this "
         "file, takes over what still holds",
         shown(path_).c_str(), differs->c_str());
  if (differs) return reading_.reset();
  for (std::uint64_t record = 0; record < record_count_; ++record) {
    std::uint64_t offset = header_bytes_ + record * record_bytes();
    RecordHeader head;
    if (!read_values(*reading_, offset, std::span(&head, 1)) || !read_values(*reading_, offset, found_)) continue;
    const std::uint64_t hash = hash64_of<float>(found_);
    records_[hash] = record;
    if (head.origin == Origin::reused) reused_poses_.push_back(hash);
  }
}

bool EvaluationCache::read(std::uint64_t record, std::span<float> controls, std::span<float> points) {
  if (!reading_) reading_.emplace(path_);
  std::uint64_t offset = header_bytes_ + record * record_bytes();
  RecordHeader head;
  return read_values(*reading_, offset, std::span(&head, 1)) && read_values(*reading_, offset, controls) &&
         read_values(*reading_, offset, points) && head.hash == record_hash(head.origin, controls, points);
}

bool EvaluationCache::find(std::span<const float> controls, std::span<float> points) {
  if (records_.empty()) return false;
  const auto known = records_.find(hash64_of(controls));
  if (known == records_.end()) return false;
  const bool whole = read(known->second, found_, points);
  if (whole && std::equal(controls.begin(), controls.end(), found_.begin())) return true;
  if (!whole) records_.erase(known);
  return false;
}

void EvaluationCache::open_for_writing() {
  make_folder(path_.has_parent_path() ? path_.parent_path() : ".");
  const bool fresh = record_count_ == 0;
  if (!fresh) {
    std::error_code failed;
    std::filesystem::resize_file(path_, header_bytes_ + record_count_ * record_bytes(), failed);
    if (failed) fail_writing(failed.message());
  }
  errno = 0;
  writing_.open(path_, std::ios::binary | (fresh ? std::ios::trunc : std::ios::app));
  if (!fresh) return;
  const std::string text = text_of(rig_);
  Header header;
  header.text_bytes = text.size();
  header.hash = hash_of(text);
  header_bytes_ = sizeof header + text.size();
  write(writing_, std::span(&header, 1));
  write(writing_, text);
}

void EvaluationCache::store(std::span<const float> controls, std::span<const float> points, Origin origin) {
  if (!writing_.is_open()) open_for_writing();
  errno = 0;
  const RecordHeader head{record_hash(origin, controls, points), origin};
  write(writing_, std::span(&head, 1));
  write(writing_, controls);
  write(writing_, points);
  if (!writing_) fail_writing(reason_of_system());
  records_[hash64_of(controls)] = record_count_++;
}

void EvaluationCache::flush() {
  errno = 0;
  if (writing_.is_open() && !writing_.flush()) fail_writing(reason_of_system());
}

double EvaluationCache::measure_record_seconds() const {
  constexpr std::uint64_t least_bytes = std::uint64_t{8} << 20;
  const std::filesystem::path path = path_.string() + ".timed";
  make_folder(path.has_parent_path() ? path.parent_path() : ".");
  std::vector<std::uint64_t> bytes((record_bytes() + least_bytes) / sizeof(std::uint64_t));
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = hash64_of(std::span<const std::size_t>(&i, 1));
  std::optional<LockedFile> file = LockedFile::open(path, LockedFile::Missing::create);
  if (!file) fail_writing(shown(path) + " is in use");
  const auto start = std::chrono::steady_clock::now();
  std::chrono::duration<double> took{};
  try {
    file->clear();
    file->write(std::as_bytes(std::span(bytes)));
    file->sync();
    const InputFile written(path);
    std::uint64_t offset = 0;
    read_values(written, offset, bytes);
    hash64_of(std::span<const std::uint64_t>(bytes));
    took = std::chrono::steady_clock::now() - start;
  } catch (...) {
    file->remove();
    throw;
  }
  file->remove();
  return took.count() * static_cast<double>(record_bytes()) / static_cast<double>(bytes.size() * sizeof bytes[0]);
}

void EvaluationCache::fail_writing(const std::string& reason) const {
  fail(Status::io, "%s: the rig's evaluations cannot be written: %s", shown(path_).c_str(), reason.c_str());
}

}  // namespace fb::bake

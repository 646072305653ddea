/** @file
 * FaceBaker authoring for C++17: the handles of facebaker_bake.h as objects, its statuses as exceptions. Header only,
 * without an ABI of its own; what facebaker_bake.h says of shapes, units, threads and errors holds here too.
 */
#ifndef FACEBAKER_FACEBAKER_BAKE_HPP
#define FACEBAKER_FACEBAKER_BAKE_HPP

#include <facebaker/facebaker_bake.h>
#include <facebaker/facebaker.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace facebaker {

/** An opened source, closed by the destructor: where poses come from. See SourceView for what can be asked of it. */
class Source {
 public:
  /** Opens dataset folders of one character, or a rig; see fb_source_open. */
  explicit Source(const std::vector<std::string>& paths, const fb_callbacks& callbacks = {}) {
    std::vector<const char*> names;
    for (const std::string& path : paths) names.push_back(path.c_str());
    fb_source_desc desc;
    fb_source_desc_init(&desc);
    desc.paths = names.data();
    desc.path_count = static_cast<std::uint32_t>(names.size());
    desc.callbacks = callbacks;
    check(fb_source_open(&desc, &handle_));
  }
  /** A rig that the host filled, which must outlive the source. */
  explicit Source(const fb_rig& rig, const fb_callbacks& callbacks = {}) {
    fb_source_desc desc;
    fb_source_desc_init(&desc);
    desc.rig = &rig;
    desc.callbacks = callbacks;
    check(fb_source_open(&desc, &handle_));
  }
  /** What a description says, such as how rigs run in child processes; see fb_source_desc. */
  explicit Source(const fb_source_desc& desc) { check(fb_source_open(&desc, &handle_)); }
  /** Takes the source over. */
  Source(Source&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  /** Swaps the sources. */
  Source& operator=(Source&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Source() { fb_source_close(handle_); }

  /** Has the poses of a live source evaluated by a host; see fb_source_spread. */
  static Source spread(Source source, const fb_spreader& spreader) {
    Source spread;
    check(fb_source_spread(source.handle_, &spreader, &spread.handle_));
    source.handle_ = nullptr;
    return spread;
  }

  /** For what has no member here. */
  fb_source* get() const noexcept { return handle_; }

 private:
  Source() = default;

  fb_source* handle_ = nullptr;
};

/** A source that is kept open elsewhere, by a Source or as the recording of a Report. */
class SourceView {
 public:
  /** The source must outlive the view. */
  SourceView(const Source& source) : SourceView(source.get()) {}
  SourceView(Source&&) = delete;  ///< a temporary has nothing to lend
  /** A handle that is not null and outlives the view. */
  explicit SourceView(fb_source* handle) : handle_(handle) {
    fb_source_info_init(&info_);
    check(fb_source_describe(handle_, &info_));
  }

  /** Name, mesh and counts; see fb_source_describe. */
  const fb_source_info& info() const { return info_; }
  /** Whether new poses can be evaluated. */
  bool live() const { return (info_.flags & FB_SOURCE_LIVE) != 0; }
  /** Name, group and range of a control. */
  fb_control control(std::uint32_t index) const {
    fb_control control;
    fb_control_init(&control);
    check(fb_source_control_at(handle_, index, &control));
    return control;
  }
  /** Controls over time; see fb_source_clip_at. */
  fb_clip clip(std::uint32_t index) const {
    fb_clip clip;
    fb_clip_init(&clip);
    check(fb_source_clip_at(handle_, index, &clip));
    return clip;
  }
  /** Positions of frames of a clip, count x 3 x vertices floats; see fb_source_read. */
  std::vector<float> read(std::uint32_t clip, std::uint64_t first, std::uint64_t count) const {
    std::vector<float> positions(count * 3 * info_.vertex_count);
    check(fb_source_read(handle_, clip, first, count, positions.data(), positions.size()));
    return positions;
  }
  /** Positions of new poses, poses x 3 x vertices floats; controls: poses x controls. See fb_source_evaluate. */
  std::vector<float> evaluate(const float* controls, std::uint64_t poses, std::uint32_t threads = 0) const {
    std::vector<float> positions(poses * 3 * info_.vertex_count);
    check(fb_source_evaluate(handle_, controls, poses, threads, positions.data(), positions.size()));
    return positions;
  }
  /** Throws unless the model is of the same face; see fb_source_check_model. */
  void check_model(const Model& model) const { check(fb_source_check_model(handle_, model.get())); }

  /** For what has no member here. */
  fb_source* get() const noexcept { return handle_; }

 private:
  fb_source* handle_;
  fb_source_info info_;
};

/** An archive with everything in it, for measuring and inspecting; closed by the destructor. Texts and arrays that it
 * returns are its own, so a temporary cannot be asked for them. */
class Archive {
 public:
  /** Reads a file; see fb_archive_open. */
  explicit Archive(const std::string& path) { check(fb_archive_open(path.c_str(), &handle_)); }
  /** Copies an archive in memory; `name` stands for its path in reports. */
  Archive(const void* bytes, std::uint64_t size, const std::string& name) {
    check(fb_archive_open_memory(bytes, size, name.c_str(), &handle_));
  }
  /** Takes the archive over. */
  Archive(Archive&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  /** Swaps the archives. */
  Archive& operator=(Archive&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Archive() { fb_archive_close(handle_); }

  /** Texts, counts and bytes; see fb_archive_describe. */
  fb_archive_info info() const& {
    fb_archive_info info;
    fb_archive_info_init(&info);
    check(fb_archive_describe(handle_, &info));
    return info;
  }
  fb_archive_info info() const&& = delete;  ///< a temporary has nothing to lend
  /** Name and size of a section. */
  fb_section section(std::uint32_t index) const& {
    fb_section section;
    fb_section_init(&section);
    check(fb_archive_section_at(handle_, index, &section));
    return section;
  }
  fb_section section(std::uint32_t index) const&& = delete;  ///< a temporary has nothing to lend
  /** Inputs and gate of a network; see fb_archive_region_at. */
  fb_region region(std::uint32_t index) const& {
    fb_region region;
    fb_region_init(&region);
    check(fb_archive_region_at(handle_, index, &region));
    return region;
  }
  fb_region region(std::uint32_t index) const&& = delete;  ///< a temporary has nothing to lend
  /** Shape of a layer of a network; see fb_archive_layer_at. */
  fb_layer layer(std::uint32_t region, std::uint32_t index) const {
    fb_layer layer;
    fb_layer_init(&layer);
    check(fb_archive_layer_at(handle_, region, index, &layer));
    return layer;
  }

  /** For what has no member here. */
  fb_archive* get() const noexcept { return handle_; }

 private:
  fb_archive* handle_ = nullptr;
};

/** The result of a call, freed by the destructor. */
class Report {
 public:
  /** Takes a handle over. */
  explicit Report(fb_report* handle) : handle_(handle) {}
  /** Takes the report over. */
  Report(Report&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  /** Swaps the reports. */
  Report& operator=(Report&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Report() { fb_report_free(handle_); }

  /** The call's document; see fb_report_json. */
  std::string json() const { return fb_report_json(handle_); }
  /** All figures as JSON; see fb_report_details. One thread at a time. */
  std::string details() const {
    const char* json = nullptr;
    check(fb_report_details(handle_, &json));
    return json;
  }
  /** Faces of the report. */
  std::uint32_t method_count() const { return fb_report_method_count(handle_); }
  /** A face that was baked or measured; its pointers are the report's. */
  fb_method method(std::uint32_t index) const& {
    fb_method method;
    fb_method_init(&method);
    check(fb_report_method_at(handle_, index, &method));
    return method;
  }
  fb_method method(std::uint32_t index) const&& = delete;  ///< a temporary has nothing to lend
  /** The recording that compare made of a live rig, for a SourceView; null where there is none. */
  fb_source* recording() const& { return fb_report_source(handle_); }
  fb_source* recording() const&& = delete;  ///< a temporary has nothing to lend

  /** For what has no member here. */
  fb_report* get() const noexcept { return handle_; }

 private:
  fb_report* handle_ = nullptr;
};

/** Samples a dataset; see fb_sample. */
inline Report sample(const fb_sample_desc& desc) {
  fb_report* report = nullptr;
  check(fb_sample(&desc, &report));
  return Report(report);
}
/** Plans poses for a program to evaluate; see fb_plan. */
inline Report plan(const fb_sample_desc& desc) {
  fb_report* report = nullptr;
  check(fb_plan(&desc, &report));
  return Report(report);
}
/** Finds all that is wrong with a dataset folder; see fb_check. */
inline Report check_dataset(const fb_check_desc& desc) {
  fb_report* report = nullptr;
  check(fb_check(&desc, &report));
  return Report(report);
}
/** Bakes a face; see fb_bake. */
inline Report bake(const fb_bake_desc& desc) {
  fb_report* report = nullptr;
  check(fb_bake(&desc, &report));
  return Report(report);
}
/** Bakes and measures several methods; see fb_compare. */
inline Report compare(const fb_compare_desc& desc) {
  fb_report* report = nullptr;
  check(fb_compare(&desc, &report));
  return Report(report);
}
/** Measures an archive; see fb_eval. */
inline Report eval(const fb_eval_desc& desc) {
  fb_report* report = nullptr;
  check(fb_eval(&desc, &report));
  return Report(report);
}
/** Packs an archive again; see fb_pack. */
inline Report pack(const fb_pack_desc& desc) {
  fb_report* report = nullptr;
  check(fb_pack(&desc, &report));
  return Report(report);
}
/** Describes an archive; see fb_inspect. */
inline Report inspect(const Archive& archive) {
  fb_report* report = nullptr;
  check(fb_inspect(archive.get(), &report));
  return Report(report);
}
/** Says what has changed between two archives; see fb_diff. */
inline Report diff(const Archive& before, const Archive& now) {
  fb_report* report = nullptr;
  check(fb_diff(before.get(), now.get(), &report));
  return Report(report);
}
/** Checks an archive against its proof; see fb_verify. */
inline Report verify(const Archive& archive) {
  fb_report* report = nullptr;
  check(fb_verify(archive.get(), &report));
  return Report(report);
}
/** Writes archives as a bag; see fb_bag. */
inline Report bag(const fb_bag_desc& desc) {
  fb_report* report = nullptr;
  check(fb_bag(&desc, &report));
  return Report(report);
}
/** Finds all that is wrong with a bag; see fb_bag_check. */
inline Report check_bag(const fb_bag_check_desc& desc) {
  fb_report* report = nullptr;
  check(fb_bag_check(&desc, &report));
  return Report(report);
}

/** Signs a file; see fb_sign. */
inline Report sign(const fb_sign_desc& desc) {
  fb_report* report = nullptr;
  check(fb_sign(&desc, &report));
  return Report(report);
}
/** Checks who vouches for a file; see fb_verify_signature. */
inline Report verify_signature(const fb_verify_signature_desc& desc) {
  fb_report* report = nullptr;
  check(fb_verify_signature(&desc, &report));
  return Report(report);
}

/** Says what the rights in what is said about a character come to, on a day or today; see fb_rights. */
inline Report rights(const char* about, const char* on = nullptr) {
  fb_report* report = nullptr;
  check(fb_rights(about, on, &report));
  return Report(report);
}

/** The frames of an animation in a NumPy file, frames x control_count floats; see fb_clip_file_read. */
inline std::vector<float> read_clip_file(const std::string& path, std::uint32_t control_count) {
  std::uint64_t frames = 0;
  check(fb_clip_file_frames(path.c_str(), control_count, &frames));
  std::vector<float> controls(frames * control_count);
  check(fb_clip_file_read(path.c_str(), control_count, 0, frames, controls.data()));
  return controls;
}

/** Joints with skin weights that move a face nearly as it moves; freed by the destructor. */
class Decomposition {
 public:
  /** See fb_decompose. */
  explicit Decomposition(const fb_decompose_desc& desc) { check(fb_decompose(&desc, &handle_)); }
  /** Takes the decomposition over. */
  Decomposition(Decomposition&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  /** Swaps the decompositions. */
  Decomposition& operator=(Decomposition&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Decomposition() { fb_decomposition_free(handle_); }

  /** Joints and weights; see fb_decomposition_describe. */
  fb_decomposition_info info() const& {
    fb_decomposition_info info;
    fb_decomposition_info_init(&info);
    check(fb_decomposition_describe(handle_, &info));
    return info;
  }
  fb_decomposition_info info() const&& = delete;  ///< a temporary has nothing to lend
  /** Frames of all joints, poses x joints x 12 floats, for poses x 3 x vertices positions; see fb_decomposition_fit. */
  std::vector<float> fit(const float* positions, std::uint64_t poses, std::uint32_t threads = 0) const {
    std::vector<float> frames(poses * info().joint_count * 12);
    check(fb_decomposition_fit(handle_, positions, poses, threads, frames.data()));
    return frames;
  }

  /** For what has no member here. */
  const fb_decomposition* get() const noexcept { return handle_; }

 private:
  fb_decomposition* handle_ = nullptr;
};

}  // namespace facebaker

#endif

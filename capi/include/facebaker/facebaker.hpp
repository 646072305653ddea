/** @file
 * FaceBaker runtime for C++17: the handles of facebaker.h as objects, its statuses as exceptions. Header only, without
 * an ABI of its own; what facebaker.h says of shapes, units, threads and errors holds here too.
 *
 * Hosts that are built without exceptions have the members whose names begin with try_, which return a status or a
 * Result, and none of those that would throw.
 */
#ifndef FACEBAKER_FACEBAKER_HPP
#define FACEBAKER_FACEBAKER_HPP

#include <facebaker/facebaker.h>

#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
/** Whether members that throw are there. */
#define FACEBAKER_EXCEPTIONS 1
#else
#define FACEBAKER_EXCEPTIONS 0
#endif

#include <cstddef>
#include <cstdint>
#include <optional>
#if FACEBAKER_EXCEPTIONS
#include <stdexcept>
#endif
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/** Objects over the handles of facebaker.h. */
namespace facebaker {

/** What a call gives that can fail: a value, or why there is none. */
template <class Value>
class Result {
 public:
  /** A value. */
  Result(Value value) : value_(std::move(value)) {}
  /** A failure, on the thread where a call returned this status, which is not FB_OK. */
  static Result failure(fb_status status) { return Result(Failed{status}); }

  /** Whether there is a value. */
  explicit operator bool() const noexcept { return value_.has_value(); }
  Value& operator*() & { return *value_; }                          ///< the value, which must be there
  const Value& operator*() const& { return *value_; }               ///< the same
  Value&& operator*() && { return std::move(*value_); }             ///< the same
  Value* operator->() { return &*value_; }                          ///< the same
  const Value* operator->() const { return &*value_; }              ///< the same
  fb_status status() const noexcept { return status_; }             ///< FB_OK with a value
  const std::string& message() const noexcept { return message_; }  ///< fb_last_error() of the failure; "" with a value

 private:
  struct Failed {
    fb_status status;
  };
  explicit Result(Failed failed) : status_(failed.status), message_(fb_last_error()) {}

  std::optional<Value> value_;
  fb_status status_ = FB_OK;
  std::string message_;
};

#if FACEBAKER_EXCEPTIONS
/** A call that failed: what() is fb_last_error(). */
class Error : public std::runtime_error {
 public:
  /** For a status that is not FB_OK, on the thread where it was returned. */
  explicit Error(fb_status status) : std::runtime_error(fb_last_error()), status_(status) {}
  /** FB_ERROR_... */
  fb_status status() const noexcept { return status_; }

 private:
  fb_status status_;
};

/** Throws Error unless the status is FB_OK. */
inline void check(fb_status status) {
  if (status != FB_OK) throw Error(status);
}
#endif

/** A loaded face. Copies share it; it is freed with the last of them. One that was moved from may only be assigned to
 * or destroyed. Threads may share a face. */
class Model {
 public:
  /** Loads a file; see fb_load. `desc` may be null. */
  static Result<Model> try_load(const std::string& path, const fb_load_desc* desc = nullptr) {
    fb_model* handle = nullptr;
    const fb_status status = fb_load(path.c_str(), desc, &handle);
    return made(status, handle);
  }
  /** Loads an archive in memory; see fb_load_memory. */
  static Result<Model> try_load(const void* bytes, std::size_t size, const fb_load_desc* desc = nullptr) {
    fb_model* handle = nullptr;
    const fb_status status = fb_load_memory(bytes, size, desc, &handle);
    return made(status, handle);
  }
  /** Loads an archive from a host's stream; see fb_load_stream. */
  static Result<Model> try_load(fb_read read, void* user, const fb_load_desc* desc = nullptr) {
    fb_model* handle = nullptr;
    const fb_status status = fb_load_stream(read, user, desc, &handle);
    return made(status, handle);
  }
#if FACEBAKER_EXCEPTIONS
  /** Loads a file; see fb_load. `desc` may be null. */
  explicit Model(const std::string& path, const fb_load_desc* desc = nullptr) {
    check(fb_load(path.c_str(), desc, &handle_));
  }
  /** Loads an archive in memory; see fb_load_memory. */
  Model(const void* bytes, std::size_t size, const fb_load_desc* desc = nullptr) {
    check(fb_load_memory(bytes, size, desc, &handle_));
  }
  /** Loads an archive from a host's stream; see fb_load_stream. */
  Model(fb_read read, void* user, const fb_load_desc* desc = nullptr) {
    check(fb_load_stream(read, user, desc, &handle_));
  }
#endif
  /** Shares the face. */
  Model(const Model& other) noexcept : handle_(other.handle_) { fb_retain(handle_); }
  /** Takes the face over. */
  Model(Model&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  /** Shares or takes over the face of another, and releases its own. */
  Model& operator=(Model other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Model() { fb_release(handle_); }

  /** Of the character. */
  std::string_view name() const& { return fb_name(handle_); }
  std::string_view name() const&& = delete;  ///< a temporary has nothing to lend
  /** Vertices of the mesh. */
  std::uint32_t vertex_count() const { return fb_vertex_count(handle_); }
  /** Floats in a pose. */
  std::uint32_t control_count() const { return fb_control_count(handle_); }
  /** Name, group and range of a control, which the model owns; see fb_control_at. */
  Result<fb_control> try_control(std::uint32_t index) const& {
    fb_control control;
    fb_control_init(&control);
    const fb_status status = fb_control_at(handle_, index, &control);
    return result(status, control);
  }
  Result<fb_control> try_control(std::uint32_t index) const&& = delete;  ///< a temporary has nothing to lend
  /** The index of a control by its name; the message names the closest one there is. */
  Result<std::uint32_t> try_find(std::string_view name) const {
    std::uint32_t index = 0;
    const fb_status status = fb_find_control(handle_, std::string(name).c_str(), &index);
    return result(status, index);
  }
  /** The index of a control by the hash of its name; see fb_name_hash and `facebaker header`. */
  Result<std::uint32_t> try_find_hash(std::uint64_t hash) const {
    std::uint32_t index = 0;
    const fb_status status = fb_find_control_hash(handle_, hash, &index);
    return result(status, index);
  }
  /** Between two poses, or with `to` null between one and its mirror; see fb_blend_controls. */
  fb_status try_blend(const float* from, const float* to, float share, float* blended) const noexcept {
    return fb_blend_controls(handle_, from, to, share, blended);
  }
#if FACEBAKER_EXCEPTIONS
  /** Name, group and range of a control; see fb_control_at. */
  fb_control control(std::uint32_t index) const& {
    fb_control control;
    fb_control_init(&control);
    check(fb_control_at(handle_, index, &control));
    return control;
  }
  fb_control control(std::uint32_t index) const&& = delete;  ///< a temporary has nothing to lend
  /** The index of a control by its exact name; the error names the closest one there is. */
  std::uint32_t find(std::string_view name) const {
    std::uint32_t index = 0;
    check(fb_find_control(handle_, std::string(name).c_str(), &index));
    return index;
  }
  /** The index of a control by the hash of its name; see fb_name_hash and `facebaker header`. */
  std::uint32_t find_hash(std::uint64_t hash) const {
    std::uint32_t index = 0;
    check(fb_find_control_hash(handle_, hash, &index));
    return index;
  }
  /** Between two poses, or with `to` null between one and its mirror; see fb_blend_controls. */
  void blend(const float* from, const float* to, float share, float* blended) const {
    check(fb_blend_controls(handle_, from, to, share, blended));
  }
#endif
  /** A pose to start from: all controls at rest. */
  std::vector<float> rest_controls() const {
    const float* rest = fb_rest_controls(handle_);
    return std::vector<float>(rest, rest + control_count());
  }
  /** 3 x vertex_count() floats, owned by the face. */
  const float* rest_positions() const& { return fb_rest_positions(handle_); }
  const float* rest_positions() const&& = delete;  ///< a temporary has nothing to lend

  /** For what has no member here. */
  fb_model* get() const noexcept { return handle_; }

 private:
  struct Owned {
    fb_model* handle;
  };
  explicit Model(Owned owned) noexcept : handle_(owned.handle) {}
  static Result<Model> made(fb_status status, fb_model* handle) {
    return status == FB_OK ? Result<Model>(Model(Owned{handle})) : Result<Model>::failure(status);
  }
  template <class Value>
  static Result<Value> result(fb_status status, const Value& value) {
    return status == FB_OK ? Result<Value>(value) : Result<Value>::failure(status);
  }

  fb_model* handle_ = nullptr;
};

/** Working memory of evaluations, one object for each thread; keeps its face loaded. */
class Scratch {
 public:
  /** For single poses, see fb_scratch_create_single; batches have the same bits, in more time. */
  static Result<Scratch> try_create(const Model& model) {
    fb_scratch* handle = nullptr;
    const fb_status status = fb_scratch_create_single(model.get(), 1, &handle);
    return made(status, model, handle);
  }
  /** For batches on `workers` (>= 1) threads at most; see fb_scratch_create. */
  static Result<Scratch> try_create(const Model& model, std::uint32_t workers) {
    fb_scratch* handle = nullptr;
    const fb_status status = fb_scratch_create(model.get(), workers, &handle);
    return made(status, model, handle);
  }
#if FACEBAKER_EXCEPTIONS
  /** For single poses, see fb_scratch_create_single; batches have the same bits, in more time. */
  explicit Scratch(const Model& model) : model_(model) {
    check(fb_scratch_create_single(model_.get(), 1, &handle_));
  }
  /** For batches on `workers` (>= 1) threads at most; see fb_scratch_create. */
  Scratch(const Model& model, std::uint32_t workers) : model_(model) {
    check(fb_scratch_create(model_.get(), workers, &handle_));
  }
#endif
  Scratch(const Scratch&) = delete;
  /** Takes the memory over. */
  Scratch(Scratch&& other) noexcept : model_(std::move(other.model_)), handle_(std::exchange(other.handle_, nullptr)) {}
  /** Takes the memory of another over, and frees its own. */
  Scratch& operator=(Scratch&& other) noexcept {
    std::swap(model_, other.model_);
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Scratch() { fb_scratch_destroy(handle_); }

  /** One pose. controls: model.control_count() floats; positions: 3 x model.vertex_count() floats. */
  fb_status try_evaluate(const float* controls, float* positions) noexcept {
    return fb_evaluate(model_.get(), handle_, controls, positions);
  }
  /** Many poses; see fb_evaluate_batch. */
  fb_status try_evaluate(const fb_batch_desc& batch) noexcept {
    return fb_evaluate_batch(model_.get(), handle_, &batch);
  }
#if FACEBAKER_EXCEPTIONS
  /** One pose. controls: model.control_count() floats; positions: 3 x model.vertex_count() floats. */
  void evaluate(const float* controls, float* positions) {
    check(fb_evaluate(model_.get(), handle_, controls, positions));
  }
  /** Many poses; see fb_evaluate_batch. */
  void evaluate(const fb_batch_desc& batch) { check(fb_evaluate_batch(model_.get(), handle_, &batch)); }
#endif
  /** Control values that the last evaluation clamped to their ranges. */
  std::uint64_t clamped_count() const { return fb_clamped_count(handle_); }

  /** For what has no member here. */
  fb_scratch* get() const noexcept { return handle_; }

 private:
  Scratch(const Model& model, fb_scratch* handle) noexcept : model_(model), handle_(handle) {}
  static Result<Scratch> made(fb_status status, const Model& model, fb_scratch* handle) {
    return status == FB_OK ? Result<Scratch>(Scratch(model, handle)) : Result<Scratch>::failure(status);
  }

  Model model_;
  fb_scratch* handle_ = nullptr;
};

#if FACEBAKER_EXCEPTIONS
/** Poses faces of different models; see fb_evaluate_many. */
inline void evaluate(const fb_many_desc& many) {
  check(fb_evaluate_many(&many, nullptr));
}
#endif

/** The scratches that all faces of a scene share, one a model, so that a face needs no memory but its outputs. For one
 * call at a time. */
class ScratchPool {
 public:
  /** `workers` (>= 1): threads of a call at most. */
  explicit ScratchPool(std::uint32_t workers) : workers_(workers) {}
  ScratchPool(const ScratchPool&) = delete;
  ScratchPool& operator=(const ScratchPool&) = delete;
  ~ScratchPool() {
    for (fb_scratch* scratch : scratches_) fb_scratch_destroy(scratch);
  }

  /** Makes room for a model, and keeps it loaded. Once for each. */
  fb_status try_add(const Model& model) {
    scratches_.push_back(nullptr);
    const fb_status status = fb_scratch_create_single(model.get(), workers_, &scratches_.back());
    if (status != FB_OK) scratches_.pop_back();
    return status;
  }
  /** Poses items whose scratch is null, each of a model that was added; see fb_evaluate_many. */
  fb_status try_evaluate(fb_many_desc many) noexcept {
    many.scratches = scratches_.data();
    many.scratch_count = static_cast<std::uint32_t>(scratches_.size());
    return fb_evaluate_many(&many, nullptr);
  }
#if FACEBAKER_EXCEPTIONS
  /** Makes room for a model, and keeps it loaded. Once for each. */
  void add(const Model& model) {
    check(try_add(model));
  }
  /** Poses items whose scratch is null, each of a model that was added; see fb_evaluate_many. */
  void evaluate(const fb_many_desc& many) {
    check(try_evaluate(many));
  }
#endif
  /** For fb_many_desc::scratches. */
  const std::vector<fb_scratch*>& get() const noexcept { return scratches_; }

 private:
  std::uint32_t workers_;
  std::vector<fb_scratch*> scratches_;
};

}  // namespace facebaker

#endif

// FaceBaker runtime for C++17: the handles of facebaker.h as objects, its statuses as exceptions. Header only, with no
// ABI of its own; the comments of facebaker.h hold here too.
#ifndef FACEBAKER_FACEBAKER_HPP
#define FACEBAKER_FACEBAKER_HPP

#include <facebaker/facebaker.h>

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace facebaker {

class Error : public std::runtime_error {
 public:
  explicit Error(fb_status status) : std::runtime_error(fb_last_error()), status_(status) {}
  fb_status status() const noexcept { return status_; }

 private:
  fb_status status_;
};

inline void check(fb_status status) {
  if (status != FB_OK) throw Error(status);
}

// A loaded face. Copies share it; it is freed with the last of them. One that was moved from may only be assigned to or
// destroyed.
class Model {
 public:
  explicit Model(const std::string& path, const fb_load_desc* desc = nullptr) {
    check(fb_load(path.c_str(), desc, &handle_));
  }
  Model(const void* bytes, std::size_t size, const fb_load_desc* desc = nullptr) {
    check(fb_load_memory(bytes, size, desc, &handle_));
  }
  Model(const Model& other) noexcept : handle_(other.handle_) { fb_retain(handle_); }
  Model(Model&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  Model& operator=(Model other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Model() { fb_release(handle_); }

  std::string_view name() const { return fb_name(handle_); }
  std::uint32_t vertex_count() const { return fb_vertex_count(handle_); }
  std::uint32_t control_count() const { return fb_control_count(handle_); }
  fb_control control(std::uint32_t index) const {
    fb_control control;
    fb_control_init(&control);
    check(fb_control_at(handle_, index, &control));
    return control;
  }
  // The index of a control by its exact name; the error names the closest one there is.
  std::uint32_t find(std::string_view name) const {
    std::uint32_t index = 0;
    check(fb_find_control(handle_, std::string(name).c_str(), &index));
    return index;
  }
  // A pose to start from: all controls at rest.
  std::vector<float> rest_controls() const {
    const float* rest = fb_rest_controls(handle_);
    return std::vector<float>(rest, rest + control_count());
  }
  const float* rest_positions() const { return fb_rest_positions(handle_); }

  // For what has no member here.
  fb_model* get() const noexcept { return handle_; }

 private:
  fb_model* handle_ = nullptr;
};

// Working memory of evaluations: one object per thread.
class Scratch {
 public:
  explicit Scratch(const Model& model, std::uint32_t workers = 1) : model_(model) {
    check(fb_scratch_create(model_.get(), workers, &handle_));
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() { fb_scratch_destroy(handle_); }

  // controls: model.control_count() floats; positions: 3 x model.vertex_count() floats.
  void evaluate(const float* controls, float* positions) {
    check(fb_evaluate(model_.get(), handle_, controls, positions));
  }
  void evaluate(const fb_batch_desc& batch) { check(fb_evaluate_batch(model_.get(), handle_, &batch)); }
  std::uint64_t clamped_count() const { return fb_clamped_count(handle_); }

  fb_scratch* get() const noexcept { return handle_; }

 private:
  Model model_;
  fb_scratch* handle_ = nullptr;
};

}  // namespace facebaker

#endif

// What an fb_scratch is, and the references that it and others hold on a model.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "base/status.h"
#include "loaded_model.h"

namespace fb::capi {

inline void retain(const fb_model* model) {
  model->references.fetch_add(1, std::memory_order_relaxed);
}

inline void release(const fb_model* model) {
  if (model->references.fetch_sub(1, std::memory_order_acq_rel) == 1) delete model;
}

struct Reference {
  explicit Reference(const fb_model* counted) : model(counted) { retain(model); }
  ~Reference() { release(model); }
  Reference(const Reference&) = delete;
  Reference& operator=(const Reference&) = delete;
  const fb_model* model;
};

}  // namespace fb::capi

struct fb_scratch {
  fb_scratch(const fb_model* model, std::uint32_t workers, std::size_t poses)
      : owner(model),
        workspaces(&model->memory),
        regions(model->evaluator.region_names().size() * workers, &model->memory),
        meshes(model->evaluator.mesh_count() * workers, &model->memory) {
    workspaces.reserve(workers);
    for (std::uint32_t worker = 0; worker < workers; ++worker)
      workspaces.emplace_back(model->evaluator, poses, model->memory);
  }

  std::atomic<bool> busy = false;
  std::atomic<bool> awaited = false;  // by fb_evaluate_many: its item has not begun
  fb::capi::Reference owner;          // before the members that use the model's memory
  std::pmr::vector<fb::runtime::Workspace> workspaces;
  std::pmr::vector<std::uint8_t> regions, meshes;  // the masks of a batch, by its first worker
  std::atomic<std::uint64_t> clamped = 0;
};

namespace fb::capi {

// The workers of a scratch that pose a batch: all of them, or one in a pool of fb_evaluate_many.
struct ScratchPart {
  explicit ScratchPart(fb_scratch& of) : scratch(of), count(of.workspaces.size()) {}
  ScratchPart(fb_scratch& of, std::size_t worker) : scratch(of), first(worker) {}

  std::span<runtime::Workspace> workspaces() const { return std::span(scratch.workspaces).subspan(first, count); }
  std::span<std::uint8_t> regions() const { return mask(scratch.regions); }
  std::span<std::uint8_t> meshes() const { return mask(scratch.meshes); }

  fb_scratch& scratch;
  std::size_t first = 0, count = 1;

 private:
  std::span<std::uint8_t> mask(std::pmr::vector<std::uint8_t>& masks) const {
    const std::size_t size = masks.size() / scratch.workspaces.size();
    return std::span(masks).subspan(first * size, size);
  }
};

// A call's use of a scratch. Fails with invalid_argument if it belongs to another model or another call is using it.
class ScratchUse {
 public:
  ScratchUse(fb_scratch* scratch, const fb_model* model) : scratch_(*scratch) { begin(scratch_, model); }
  ~ScratchUse() { end(scratch_); }
  ScratchUse(const ScratchUse&) = delete;
  ScratchUse& operator=(const ScratchUse&) = delete;

  static void begin(fb_scratch& scratch, const fb_model* model) {
    if (scratch.owner.model != model) fail(Status::invalid_argument, "scratch was created for another model");
    if (scratch.busy.exchange(true, std::memory_order_acquire))
      fail(Status::invalid_argument, "scratch is in use by another call; each thread needs its own");
  }
  static void end(fb_scratch& scratch) { scratch.busy.store(false, std::memory_order_release); }

 private:
  fb_scratch& scratch_;
};

}  // namespace fb::capi

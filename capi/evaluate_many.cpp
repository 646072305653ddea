#include <facebaker/facebaker.h>

#include <algorithm>
#include <atomic>

#include "abi_guard.h"
#include "base/parallel.h"
#include "batch_reader.h"
#include "scratch.h"

namespace fb::capi {
namespace {

[[noreturn]] void fail_item(std::uint32_t index, const Error& error) {
  fail(error.status(), "item %u: %s", index, error.what());
}

// The scratches of a call, which no other call, and no other item, uses meanwhile: those that all items share, and
// those of single items.
class ManyScratches {
 public:
  explicit ManyScratches(const fb_many_desc& desc) : desc_(desc) {}
  ~ManyScratches() {
    while (taken_ > 0)
      if (fb_scratch* scratch = desc_.items[--taken_].scratch) ScratchUse::end(*scratch);
    while (shared_ > 0) ScratchUse::end(*desc_.scratches[--shared_]);
  }
  ManyScratches(const ManyScratches&) = delete;
  ManyScratches& operator=(const ManyScratches&) = delete;

  void take_shared() {
    if (desc_.scratch_count > 0) require(desc_.scratches, "fb_many_desc: scratches");
    for (; shared_ < desc_.scratch_count; ++shared_) {
      fb_scratch* scratch = desc_.scratches[shared_];
      if (!scratch) fail(Status::invalid_argument, "fb_many_desc: scratch %u is null", shared_);
      ScratchUse::begin(*scratch, scratch->owner.model);
      scratch->clamped = 0;
      workers_ = std::min(workers_, scratch->workspaces.size());
    }
  }

  // The next item's.
  void take_item() {
    const fb_many_item& item = desc_.items[taken_];
    require(item.model, "model");
    require(item.batch, "batch");
    require_size(item.batch->struct_size, "fb_batch_desc");
    if (!item.scratch && !shared_of(item.model)) require(item.scratch, "scratch");
    if (item.scratch) {
      ScratchUse::begin(*item.scratch, item.model);
      item.scratch->awaited = true;
    }
    ++taken_;
  }

  // Threads that may run, as far as scratches are concerned.
  std::size_t workers() const { return workers_; }

  // What poses an item on a worker.
  ScratchPart part(const fb_many_item& item, std::size_t worker) const {
    return item.scratch ? ScratchPart(*item.scratch) : ScratchPart(*shared_of(item.model), worker);
  }

 private:
  fb_scratch* shared_of(const fb_model* model) const {
    const auto is_of = [&](const fb_scratch* scratch) { return scratch->owner.model == model; };
    const auto end = desc_.scratches + desc_.scratch_count, found = std::find_if(desc_.scratches, end, is_of);
    return found == end ? nullptr : *found;
  }

  const fb_many_desc& desc_;
  std::uint32_t shared_ = 0, taken_ = 0;
  std::size_t workers_ = SIZE_MAX;
};

// Without a number of threads a host's scheduler may take one item each.
Parallel parallel_of(const fb_many_desc& desc, std::size_t workers) {
  if (desc.threads > workers)
    fail(Status::invalid_argument, "fb_many_desc: %u threads, but its scratches have %zu workers", desc.threads,
         workers);
  const std::size_t most = std::min<std::size_t>({desc.item_count, workers, INT32_MAX});
  const std::size_t threads = desc.threads > 0 ? desc.threads : desc.parallel_for ? most : worker_count({});
  return {static_cast<int>(std::min(threads, most)), desc.parallel_for, desc.parallel_user};
}

// The items of a call while they are posed, by any of its threads.
class ManyItems {
 public:
  ManyItems(const fb_many_desc& desc, const ManyScratches& scratches, std::size_t workers)
      : desc_(desc), scratches_(scratches), workers_(workers), first_failed_(desc.item_count) {}

  void evaluate(std::size_t index, std::size_t worker) {
    if (index >= desc_.item_count || worker >= workers_ || was_begun(desc_.items[index]))
      fail(Status::invalid_argument, "the host's parallel_for gave task %zu of %u twice, or too many", index,
           desc_.item_count);
    ++begun_;
    const auto item = static_cast<std::uint32_t>(index);
    try {
      evaluate_item(item, worker);
    } catch (const Error& error) {
      note_failed(item);
      fail_item(item, error);
    } catch (...) {
      note_failed(item);
      throw;
    }
  }
  std::uint32_t begun() const { return begun_; }
  std::uint32_t first_failed() const { return first_failed_; }

 private:
  static bool was_begun(const fb_many_item& item) { return item.scratch && !item.scratch->awaited.exchange(false); }

  void evaluate_item(std::uint32_t index, std::size_t worker) {
    const fb_many_item& item = desc_.items[index];
    fb_batch_desc batch = read_batch_desc(*item.batch);
    batch.threads = 1;
    batch.parallel_for = nullptr;
    const ScratchPart part = scratches_.part(item, worker);
    const std::uint64_t clamped = evaluate_batch(part, batch);
    if (item.scratch)
      part.scratch.clamped = clamped;
    else
      part.scratch.clamped += clamped;
    if (desc_.clamped) desc_.clamped[index] = clamped;
  }

  void note_failed(std::uint32_t item) {
    std::uint32_t before = first_failed_;
    while (item < before && !first_failed_.compare_exchange_weak(before, item)) {
    }
  }

  const fb_many_desc& desc_;
  const ManyScratches& scratches_;
  const std::size_t workers_;
  std::atomic<std::uint32_t> first_failed_, begun_ = 0;
};

// Sets *failed, where it is not null, to the first item that is refused or fails.
void evaluate_items(const fb_many_desc& desc, std::uint32_t* failed) {
  require(desc.items, "fb_many_desc: items");
  ManyScratches scratches(desc);
  scratches.take_shared();
  const Parallel parallel = parallel_of(desc, scratches.workers());
  for (std::uint32_t i = 0; i < desc.item_count; ++i) {
    try {
      scratches.take_item();
    } catch (const Error& error) {
      if (failed) *failed = i;
      fail_item(i, error);
    }
  }
  if (desc.clamped) std::fill_n(desc.clamped, desc.item_count, std::uint64_t(0));
  ManyItems items(desc, scratches, worker_count(parallel));
  try {
    parallel_for(parallel, desc.item_count,
                 [&](std::size_t index, std::size_t worker) { items.evaluate(index, worker); });
  } catch (...) {
    if (failed) *failed = items.first_failed();
    throw;
  }
  if (items.begun() != desc.item_count)
    fail(Status::invalid_argument, "the host's parallel_for ran %u items of %u", items.begun(), desc.item_count);
}

}  // namespace
}  // namespace fb::capi

extern "C" {

void fb_many_desc_fill(fb_many_desc* to, uint32_t struct_size) {
  fb::capi::fill_struct(to, struct_size, {});
}

fb_status fb_evaluate_many(const fb_many_desc* desc, uint32_t* failed) {
  return fb::capi::abi_guard([&] {
    fb::capi::require(desc, "desc");
    const fb_many_desc known = fb::capi::read_struct(*desc, fb_many_desc_init, "fb_many_desc");
    if (failed) *failed = known.item_count;
    if (known.item_count > 0) fb::capi::evaluate_items(known, failed);
  });
}

}  // extern "C"

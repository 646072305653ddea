#include <facebaker/facebaker.h>

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

// The scratches of a list of items, which no other call, and no other item, uses meanwhile.
class ItemScratches {
 public:
  explicit ItemScratches(const fb_many_desc& desc) : items_(desc.items) {}
  ~ItemScratches() {
    while (taken_ > 0) ScratchUse::end(*items_[--taken_].scratch);
  }
  ItemScratches(const ItemScratches&) = delete;
  ItemScratches& operator=(const ItemScratches&) = delete;

  // The next item's.
  void take() {
    const fb_many_item& item = items_[taken_];
    require(item.model, "model");
    require(item.scratch, "scratch");
    require(item.batch, "batch");
    require_size(item.batch->struct_size, "fb_batch_desc");
    ScratchUse::begin(*item.scratch, item.model);
    item.scratch->awaited = true;
    ++taken_;
  }

 private:
  const fb_many_item* items_;
  std::uint32_t taken_ = 0;
};

void evaluate_item(const fb_many_item& item) {
  fb_batch_desc batch = read_batch_desc(*item.batch);
  batch.threads = 1;
  batch.parallel_for = nullptr;
  evaluate_batch(*item.scratch, batch);
}

// Without a number of threads a host's scheduler may take one item each.
Parallel parallel_of(const fb_many_desc& desc) {
  const std::uint32_t most = std::min<std::uint32_t>(desc.item_count, INT32_MAX);
  const std::size_t threads = desc.threads > 0 ? desc.threads : desc.parallel_for ? most : worker_count({});
  return {static_cast<int>(std::min<std::size_t>(threads, most)), desc.parallel_for, desc.parallel_user};
}

// Sets *failed, where it is not null, to the first item that is refused or fails.
void evaluate_items(const fb_many_desc& desc, std::uint32_t* failed) {
  require(desc.items, "fb_many_desc: items");
  ItemScratches scratches(desc);
  for (std::uint32_t i = 0; i < desc.item_count; ++i) {
    try {
      scratches.take();
    } catch (const Error& error) {
      if (failed) *failed = i;
      fail_item(i, error);
    }
  }
  std::atomic<std::uint32_t> first_failed = desc.item_count, begun = 0;
  const auto note_failed = [&](std::uint32_t item) {
    std::uint32_t before = first_failed;
    while (item < before && !first_failed.compare_exchange_weak(before, item)) {
    }
  };
  const auto evaluate = [&](std::size_t index, std::size_t) {
    // The worker does not matter, as each item has a scratch of its own.
    if (index >= desc.item_count || !desc.items[index].scratch->awaited.exchange(false))
      fail(Status::invalid_argument, "the host's parallel_for gave task %zu of %u twice, or too many", index,
           desc.item_count);
    ++begun;
    const auto item = static_cast<std::uint32_t>(index);
    try {
      evaluate_item(desc.items[item]);
    } catch (const Error& error) {
      note_failed(item);
      fail_item(item, error);
    } catch (...) {
      note_failed(item);
      throw;
    }
  };
  try {
    parallel_for(parallel_of(desc), desc.item_count, evaluate);
  } catch (...) {
    if (failed) *failed = first_failed;
    throw;
  }
  if (begun < desc.item_count)
    fail(Status::invalid_argument, "the host's parallel_for ran %u items of %u", begun.load(), desc.item_count);
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

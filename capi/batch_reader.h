// Batches as callers describe them.
#pragma once

#include <facebaker/facebaker.h>

#include <cstdint>

namespace fb::capi {

struct ScratchPart;

// A caller's description, of any size, with defaults for what it does not have.
fb_batch_desc read_batch_desc(const fb_batch_desc& given);

// Poses a batch, as read_batch_desc returns it, with workers of a scratch that the caller uses, see ScratchUse. Returns
// how many control values were clamped.
std::uint64_t evaluate_batch(const ScratchPart& part, const fb_batch_desc& batch);

// Quantises poses of a caller's description, of any size, likewise.
void evaluate_quantised(fb_scratch& scratch, const fb_quantised_desc& given);

}  // namespace fb::capi

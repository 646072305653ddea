// Batches as callers describe them.
#pragma once

#include <facebaker/facebaker.h>

namespace fb::capi {

// A caller's description, of any size, with defaults for what it does not have.
fb_batch_desc read_batch_desc(const fb_batch_desc& given);

// Poses a batch, as read_batch_desc returns it, with a scratch that the caller uses, see ScratchUse.
void evaluate_batch(fb_scratch& scratch, const fb_batch_desc& batch);

}  // namespace fb::capi

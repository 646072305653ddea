// Batches as callers describe them.
#pragma once

#include <facebaker/facebaker.h>

namespace fb::capi {

// Poses a batch with a scratch that the caller uses, see ScratchUse. batch: read by read_struct.
void evaluate_batch(fb_scratch& scratch, const fb_batch_desc& batch);

}  // namespace fb::capi

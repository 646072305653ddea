#include "bake/rig/source_decorator.h"

#include "bake/rig/evaluation_backend.h"

namespace fb::bake {

std::unique_ptr<EvaluationBackend> SourceDecorator::make_backend(const Parallel& parallel) {
  return source_.make_backend(parallel);
}

}  // namespace fb::bake

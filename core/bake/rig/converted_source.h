#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>

#include "bake/rig/source_decorator.h"

namespace fb::bake {

// Another source that gives the points of its poses otherwise.
class ConvertedSource : public SourceDecorator {
 public:
  const Mesh& rest() const override { return rest_; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override;
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override;

  // Points of poses from those that the other source gives. Any number of threads may call it.
  virtual void convert(std::span<const float> controls, std::span<const float> from, std::size_t poses,
                       std::span<float> to) const = 0;

 protected:
  // `source` must outlive this. Its rest mesh is for a derived class to change.
  explicit ConvertedSource(Source& source) : SourceDecorator(source), rest_(source.rest()) {}
  explicit ConvertedSource(std::unique_ptr<Source> source)
      : SourceDecorator(std::move(source)), rest_(this->source().rest()) {}

  Mesh rest_;
};

}  // namespace fb::bake

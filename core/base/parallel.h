// Parallel loops: serial, on a host's threads, or with OpenMP. parallel.cpp is the only file with an OpenMP pragma.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>

namespace fb {

// A non-owning reference to a callable void(index, worker). Unlike std::function it never allocates.
class LoopBody {
 public:
  template <class F>
  requires(!std::is_same_v<std::remove_cvref_t<F>, LoopBody>) LoopBody(F&& body)  // NOLINT: implicit by design
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(body)))),
        call_([](void* object, std::size_t index, std::size_t worker) {
          (*static_cast<std::remove_reference_t<F>*>(object))(index, worker);
        }) {}
  void operator()(std::size_t index, std::size_t worker) const { call_(object_, index, worker); }

 private:
  void* object_;
  void (*call_)(void*, std::size_t, std::size_t);
};

// A host's scheduler, with the signature of fb_parallel_for in facebaker.h: calls task(context, index, worker) once for
// every index < count with worker < workers, never two calls with the same worker at once, and returns when all are
// done.
using HostTask = void (*)(void* context, std::uint32_t index, std::uint32_t worker);
using HostParallelFor = void (*)(void* user, std::uint32_t count, std::uint32_t workers, HostTask task, void* context);

class Progress;

struct Parallel {
  int threads = 0;  // at most this many workers; 0: as many as OpenMP would use, 1 without OpenMP
  HostParallelFor host = nullptr;
  void* host_user = nullptr;
  Progress* progress = nullptr;  // asked by the first worker after each of its items; null: nobody is
};

// The largest number of workers of a loop with this setting.
std::size_t worker_count(const Parallel& parallel);

// Calls body(index, worker) for every index < count, in any order; serial inside another parallel region. Rethrows the
// exception of the lowest failing index after the loop; once the progress is cancelled, items that have not begun are
// left out and Error(interrupted) is thrown. With OpenMP, a loop runs on fewer threads where the system has no more,
// and in a child of fork() on threads of its own instead; otherwise it allocates nothing.
void parallel_for(const Parallel& parallel, std::size_t count, LoopBody body);

}  // namespace fb

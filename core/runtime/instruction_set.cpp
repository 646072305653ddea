#include "runtime/instruction_set.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <string>

#include "base/status.h"

#if defined(__x86_64__)
#include <cpuid.h>
#elif defined(__aarch64__) && defined(__linux__)
#include <asm/hwcap.h>
#include <sys/auxv.h>
#endif

namespace fb::runtime {
namespace {

// From the slowest to the fastest.
constexpr const PoseKernels* built[] = {&scalar_kernels,
#if defined(__x86_64__)
                                        &sse2_kernels, &avx2_kernels, &avx_vnni_kernels, &avx512_vnni_kernels
#elif defined(__aarch64__)
                                        &neon_kernels, &neon_dot_kernels
#elif defined(__wasm_simd128__)
                                        &wasm_simd_kernels
#endif
};

#if defined(__x86_64__)
// __builtin_cpu_supports also checks that the system saves the registers, but not all compilers know f16c and avxvnni.
bool has_avx2_and_f16c() {
  unsigned a = 0, b = 0, c = 0, d = 0;
  return __builtin_cpu_supports("avx2") && __get_cpuid(1, &a, &b, &c, &d) && (c & (1u << 29));
}
bool has_avx_vnni() {
  unsigned a = 0, b = 0, c = 0, d = 0;
  return __get_cpuid_count(7, 1, &a, &b, &c, &d) && (a & (1u << 4));
}

bool is_supported(const PoseKernels* kernels) {
  if (kernels == &scalar_kernels || kernels == &sse2_kernels) return true;
  if (!has_avx2_and_f16c()) return false;
  if (kernels == &avx_vnni_kernels) return has_avx_vnni();
  if (kernels == &avx512_vnni_kernels)
    return __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512vnni");
  return true;
}
#elif defined(__aarch64__)
bool is_supported(const PoseKernels* kernels) {
  if (kernels != &neon_dot_kernels) return true;
#if defined(__linux__)
  return getauxval(AT_HWCAP) & HWCAP_ASIMDDP;
#elif defined(__APPLE__)
  return true;  // on every Apple processor
#else
  return false;
#endif
}
#else
bool is_supported(const PoseKernels*) {
  return true;
}
#endif

// The number of `built` kernels up to a cap. `source`: the origin of the cap, for the message.
std::size_t count_up_to(const char* cap, const char* source) {
  if (!cap || !*cap) return std::size(built);
  const auto named = [&](const PoseKernels* kernels) { return std::strcmp(kernels->name, cap) == 0; };
  const auto found = std::find_if(std::begin(built), std::end(built), named);
  if (found != std::end(built)) return found - std::begin(built) + 1;
  std::string names;
  for (const PoseKernels* kernels : built) names += (names.empty() ? "" : ", ") + std::string(kernels->name);
  fail(Status::invalid_argument, "%s: \"%s\" is not one of %s", source, cap, names.c_str());
}

}  // namespace

const PoseKernels& choose_kernels(const char* cap) {
  std::size_t count = std::min(count_up_to(cap, "instruction set"),
                               count_up_to(std::getenv(instruction_set_variable), instruction_set_variable));
  while (!is_supported(built[count - 1])) --count;
  return *built[count - 1];
}

std::vector<const PoseKernels*> built_kernels() {
  return {std::begin(built), std::end(built)};
}

std::vector<const PoseKernels*> runnable_kernels() {
  std::vector<const PoseKernels*> found;
  std::copy_if(std::begin(built), std::end(built), std::back_inserter(found), is_supported);
  return found;
}

}  // namespace fb::runtime

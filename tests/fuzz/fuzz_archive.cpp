// Feeds arbitrary bytes to the archive reader: as they are, and with all checksums corrected so that the code behind
// them is reached. Accepted archives are evaluated.
#include <vector>

#include "archive/reader.h"
#include "archive_fuzzing.h"
#include "runtime/evaluator.h"

namespace {

constexpr std::uint64_t max_bytes = std::uint64_t(16) << 20;

void read_and_evaluate(const fb::Bytes& bytes) {
  try {
    const fb::archive::Archive archive = fb::archive::read_archive(bytes, {max_bytes});
    const fb::runtime::Evaluator face(archive.model);
    if (face.bytes() > max_bytes) return;
    fb::runtime::Workspace workspace(face);
    std::vector<float> controls, positions(archive.model.rest.points.size());
    for (const fb::Control& control : archive.model.schema.controls) controls.push_back(control.maximum);
    face.evaluate(controls.data(), positions.data(), workspace);
  } catch (const fb::Error& error) {
    if (std::strlen(error.what()) < 10) __builtin_trap();  // every refusal has a message
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const auto* first = reinterpret_cast<const std::byte*>(data);
  const fb::Bytes bytes(first, first + size);
  read_and_evaluate(bytes);
  read_and_evaluate(fuzz::with_valid_checksums(bytes));
  return 0;
}

#ifdef FB_FUZZ
extern "C" std::size_t LLVMFuzzerCustomMutator(unsigned char* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  return fuzz::mutate(data, size, max_size, seed);
}
#endif

// Feeds arbitrary bytes to the reader of NumPy arrays.
#include <vector>

#include "bake/dataset/npy.h"
#include "fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  fuzz::expect_message([&] {
    const fb::bake::NpyFile file(fuzz::put("array.npy", data, size));
    if (file.integer()) fuzz::expect_message([&] { file.read_integers(); });
    // An array without numbers may have any number of rows.
    const std::size_t rows = std::min<std::size_t>(file.rows(), size);
    std::vector<float> values(rows * file.row_size());
    file.read(file.rows() - rows, rows, values);
  });
  return 0;
}

// A program without exceptions and RTTI: the library uses both inside, and lets neither out.
//   strict FACE.fbk
#include <facebaker/facebaker.h>

#include <cstdint>
#include <cstdio>
#include <cstring>

int main(int argc, char** argv) {
  fb_model* model = nullptr;
  fb_scratch* scratch = nullptr;
  if (argc != 2) return 2;
  // Each of these is an exception inside.
  if (fb_load("no such file", nullptr, &model) != FB_ERROR_NOT_FOUND) return 1;
  if (fb_load_memory("no archive", 10, nullptr, &model) != FB_ERROR_NOT_AN_ARCHIVE) return 1;
  if (fb_load(argv[1], nullptr, &model) != FB_OK) return 1;
  std::uint32_t index = 0;
  if (fb_find_control(model, "no such control", &index) != FB_ERROR_NOT_FOUND) return 1;
  if (!std::strstr(fb_last_error(), "no such control")) return 1;
  if (fb_scratch_create(model, 1, &scratch) != FB_OK) return 1;
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = 1;
  if (fb_evaluate_batch(model, scratch, &batch) != FB_ERROR_INVALID_ARGUMENT) return 1;
  std::printf("%s\n", fb_last_error());
  fb_scratch_destroy(scratch);
  fb_release(model);
}

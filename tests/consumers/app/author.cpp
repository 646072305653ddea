// Both halves of the API come from the one library.
#include <facebaker/facebaker_bake.h>

#include <cstring>
#include <facebaker/facebaker.hpp>

int main() {
  fb_bake_desc desc;
  fb_bake_desc_init(&desc);
  try {
    facebaker::check(fb_bake(&desc, nullptr));
  } catch (const facebaker::Error& error) {
    return error.status() == FB_ERROR_INVALID_ARGUMENT && std::strstr(error.what(), "source") ? 0 : 1;
  }
  return 1;
}

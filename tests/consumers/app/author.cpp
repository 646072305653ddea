// Both halves of the API come from the one library.
#include <cstring>
#include <facebaker/facebaker_bake.hpp>

int main() {
  fb_bake_desc desc;
  fb_bake_desc_init(&desc);
  try {
    facebaker::bake(desc);
  } catch (const facebaker::Error& error) {
    return error.status() == FB_ERROR_INVALID_ARGUMENT && std::strstr(error.what(), "source") ? 0 : 1;
  }
  return 1;
}

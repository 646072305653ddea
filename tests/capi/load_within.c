/* load_within FILE LIMIT SPARE: loads an archive with LIMIT as max_model_bytes and no other limit, in a process that
 * may not grow by more than LIMIT and SPARE bytes (0: without a limit). Prints the status and by how many bytes it
 * grew. */
#include <facebaker/facebaker.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

/* A line of /proc/self/status, in bytes. */
static unsigned long long of_process(const char* key) {
  char line[256];
  unsigned long long kilobytes = 0;
  FILE* file = fopen("/proc/self/status", "r");
  if (!file) return 0;
  while (fgets(line, sizeof line, file))
    if (strncmp(line, key, strlen(key)) == 0) kilobytes = strtoull(line + strlen(key), NULL, 10);
  fclose(file);
  return kilobytes << 10;
}

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const unsigned long long limit = strtoull(argv[2], NULL, 10), spare = strtoull(argv[3], NULL, 10);
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  desc.max_model_bytes = desc.max_name_bytes = desc.max_vertices = desc.max_polygons = desc.max_features = UINT64_MAX;
  if (limit > 0) desc.max_model_bytes = limit;
  const unsigned long long before = of_process("VmSize:");
  if (limit > 0) {
    const struct rlimit most = {before + limit + spare, before + limit + spare};
    if (setrlimit(RLIMIT_AS, &most) != 0) return 3;
  }
  fb_model* model = NULL;
  const fb_status status = fb_load(argv[1], &desc, &model);
  if (status != FB_OK) fprintf(stderr, "%s\n", fb_last_error());
  printf("%d %llu\n", (int)status, of_process("VmPeak:") - before);
  fb_release(model);
  return 0;
}

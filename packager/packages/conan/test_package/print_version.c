#include <facebaker/facebaker.h>
#include <stdio.h>

int main(void) {
  printf("FaceBaker %s\n", fb_version_string());
  return 0;
}

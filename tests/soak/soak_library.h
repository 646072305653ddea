// The runtime library, opened while the program runs.
#pragma once

#include <dlfcn.h>
#include <facebaker/facebaker.h>

#include <cstdio>
#include <cstdlib>

namespace soak {

class Library {
 public:
  explicit Library(const char* path) : handle_(dlopen(path, RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) fail();
    load(fb_last_error, "fb_last_error");
    load(fb_load, "fb_load");
    load(fb_load_memory, "fb_load_memory");
    load(fb_retain, "fb_retain");
    load(fb_release, "fb_release");
    load(fb_scratch_create, "fb_scratch_create");
    load(fb_scratch_destroy, "fb_scratch_destroy");
    load(fb_evaluate, "fb_evaluate");
    load(fb_evaluate_batch, "fb_evaluate_batch");
    load(fb_control_count, "fb_control_count");
    load(fb_vertex_count, "fb_vertex_count");
    load(fb_rest_controls, "fb_rest_controls");
    load(load_desc_fill_, "fb_load_desc_fill");
    load(batch_desc_fill_, "fb_batch_desc_fill");
  }
  ~Library() { dlclose(handle_); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  fb_load_desc load_desc() const {
    fb_load_desc desc;
    load_desc_fill_(&desc, sizeof desc);
    return desc;
  }
  fb_batch_desc batch_desc() const {
    fb_batch_desc desc;
    batch_desc_fill_(&desc, sizeof desc);
    return desc;
  }

  decltype(&::fb_last_error) fb_last_error;
  decltype(&::fb_load) fb_load;
  decltype(&::fb_load_memory) fb_load_memory;
  decltype(&::fb_retain) fb_retain;
  decltype(&::fb_release) fb_release;
  decltype(&::fb_scratch_create) fb_scratch_create;
  decltype(&::fb_scratch_destroy) fb_scratch_destroy;
  decltype(&::fb_evaluate) fb_evaluate;
  decltype(&::fb_evaluate_batch) fb_evaluate_batch;
  decltype(&::fb_control_count) fb_control_count;
  decltype(&::fb_vertex_count) fb_vertex_count;
  decltype(&::fb_rest_controls) fb_rest_controls;

 private:
  [[noreturn]] static void fail() {
    std::fprintf(stderr, "soak: %s\n", dlerror());
    std::exit(2);
  }
  template <class Function>
  void load(Function& function, const char* name) {
    function = reinterpret_cast<Function>(dlsym(handle_, name));
    if (!function) fail();
  }

  void* handle_;
  decltype(&::fb_load_desc_fill) load_desc_fill_;
  decltype(&::fb_batch_desc_fill) batch_desc_fill_;
};

}  // namespace soak

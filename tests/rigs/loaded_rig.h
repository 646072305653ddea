// A rig plugin opened the way a host does it, for tests.
#pragma once

#include <facebaker/facebaker_rig.h>

#include <string>
#include <vector>

class LoadedRig {
 public:
  // file: the plugin. Check status before anything else.
  explicit LoadedRig(const char* file);
  ~LoadedRig();
  LoadedRig(const LoadedRig&) = delete;
  LoadedRig& operator=(const LoadedRig&) = delete;

  const fb_rig* operator->() const { return &rig_; }
  // Poses x 3 x vertices.
  std::vector<float> evaluate(const std::vector<float>& controls) const;
  // Of the rest mesh's bounding box.
  double diagonal() const;
  // The group of a control; "" if there is no such control.
  std::string group(const std::string& control) const;

  fb_status status = FB_ERROR_RIG;
  std::string message;

 private:
  void* library_ = nullptr;
  fb_rig rig_ = {};
};

// Whether the data of a real rig is there; says so on standard output where not, in the words by which ctest knows a
// skipped test.
bool have_data(const char* folder);

// The largest difference of two arrays of one length.
double largest_difference(const std::vector<float>& a, const std::vector<float>& b);

// Checks what every rig promises: polygons of vertices that exist, the rest pose exact, and the same bits whether poses
// are evaluated one by one, as a block or on four threads at once.
void check_promises(const LoadedRig& rig, const std::vector<float>& controls);

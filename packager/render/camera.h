#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "base/vector3.h"

namespace fb {

struct Box {
  Vector3 low, high;
};

// From where a face is looked at. A face looks along +z if y is up, along -y if z is up.
struct View {
  float yaw = 0;              // degrees; positive shows the side of the face that is on the right of the picture
  float pitch = 0;            // degrees; positive looks down from above
  float field_of_view = 20;   // degrees, of the picture's height
  float margin = 0.06f;       // left free at each edge, in picture widths or heights
  std::optional<Box> region;  // only points inside it need to be in the picture; none: all points
};

// A perspective camera. Camera space: x to the right, y up, z towards the camera, origin at the camera.
struct Camera {
  Vector3 right, up, back;  // orthonormal, in the space of the points
  Vector3 position;
  float focal = 1;  // image plane distance: picture height / 2 at distance focal
  float aspect = 1;

  Vector3 to_camera(Vector3 point) const;
};

// The nearest camera of this view that has all the wanted points in a picture of width / height = aspect.
Camera frame(std::span<const float> points, std::string_view up_axis, const View& view, float aspect);

}  // namespace fb

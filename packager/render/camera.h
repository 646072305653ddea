#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "base/vector3.h"

namespace fb::tool {

struct BoundingBox {
  Vector3 low, high;
};

// The direction a face is looked at from. A face looks along +z if y is up, along -y if z is up.
struct View {
  float yaw = 0;                      // degrees; positive shows the side of the face that is on the right of the image
  float pitch = 0;                    // degrees; positive looks down from above
  float field_of_view = 20;           // degrees, vertical
  float margin = 0.06f;               // left free at each edge, as a share of the image's width or height
  std::optional<BoundingBox> region;  // the points that must be in the image; none: all of them
};

// A perspective camera. Camera space: x to the right, y up, z towards the camera, origin at the camera.
struct Camera {
  Vector3 right, up, back;  // orthonormal, in the space of the points
  Vector3 position;
  float focal = 1;   // focal length, in half heights of the image
  float aspect = 1;  // width / height

  Vector3 to_camera(Vector3 point) const;
  // Where a point is in the image: 0 to 1 from left to right and from top to bottom.
  std::array<float, 2> project(Vector3 point) const;
};

// The nearest camera of this view that has all points, or those of view.region, in an image of this aspect.
// points: 3 x vertices; up_axis: "y" or "z".
Camera fit_camera(std::span<const float> points, std::string_view up_axis, const View& view, float aspect);

}  // namespace fb::tool

#include "client/bench/evaluation/truth/place_text.h"

#include <absl/strings/str_format.h>

namespace steadymap {

std::string PlaceText(const Eigen::Vector3d& point_world) {
  return absl::StrFormat("(%.2f, %.2f, %.2f)", point_world.x(), point_world.y(), point_world.z());
}

}  // namespace steadymap

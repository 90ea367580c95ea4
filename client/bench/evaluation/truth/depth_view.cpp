#include "client/bench/evaluation/truth/depth_view.h"

#include <cstdint>

namespace steadymap {

DepthView ViewOf(const Frame& frame) {
  const Image<std::uint16_t>& units = frame.depth.units;
  DepthView view = {
      frame.camera, frame.T_world_camera, Image<float>(units.width_px(), units.height_px())};
  const auto metres_per_unit = static_cast<float>(frame.depth.metres_per_unit);
  for (std::size_t i = 0; i < units.size(); ++i) {
    const std::uint16_t depth = units.data()[i];
    const bool has_return = depth != kNoDepth && depth != kInvalidDepth;
    view.depth_m.data()[i] = has_return ? static_cast<float>(depth) * metres_per_unit : 0.0F;
  }
  return view;
}

}  // namespace steadymap

#include "tests/watch/changing_hall.h"

#include <cmath>

#include "core/frame/frame.h"
#include "core/frame/image_codec.h"
#include "proto/convert_frame.h"
#include "proto/convert_geometry.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::Scene;
using ::steadymap::testing::SceneBody;

constexpr std::uint16_t kHallWall = 4;
constexpr std::uint16_t kHallGoods = 7;
constexpr int kLooks = 6;

SceneBody Pile(double y_m, double x_m = 1.6) {
  return Body(kHallGoods, {x_m, y_m - 0.2, -0.4}, {x_m + 0.4, y_m + 0.2, 0.1});
}

std::vector<Scene> AllScenes() {
  const SceneBody wall = Body(kHallWall, {2.6, -3.0, -2.0}, {2.8, 3.0, 2.0});
  return {{wall, Pile(-0.5), Pile(0.4)},
          {wall, Pile(-0.5)},
          {wall, Pile(0.4), Pile(-0.3, 1.2)},
          {wall},
          {wall, Pile(-0.4), Pile(0.1, 1.9), Pile(0.6)}};
}

v1::Frame ToWire(const Frame& frame) {
  v1::Frame message;
  *message.mutable_intrinsics() = ToProto(frame.camera);
  *message.mutable_world_from_camera() = ToProto(frame.T_world_camera);
  message.mutable_depth()->set_encoding(v1::DEPTH_ENCODING_RAW_UINT16);
  message.mutable_depth()->set_metres_per_unit(frame.depth.metres_per_unit);
  message.mutable_depth()->set_data(EncodePixels(frame.depth.units, PixelEncoding::kRawUint16));
  message.mutable_labels()->set_encoding(v1::LABEL_ENCODING_RAW_UINT16);
  message.mutable_labels()->set_data(EncodePixels(frame.labels, PixelEncoding::kRawUint16));
  return message;
}

}  // namespace

ChangingHall::ChangingHall() {
  for (const Scene& scene : AllScenes()) {
    std::vector<v1::Frame>& looks = scenes_.emplace_back();
    for (int look = 0; look < kLooks; ++look) {
      looks.push_back(ToWire(RenderScene(
          scene,
          {.eye_world = {0.0, 0.4 * std::sin(0.7 * look), 0.1}, .target_world = {2.0, 0.1, 0.0}})));
    }
  }
}

void ChangingHall::Rearrange(std::mt19937* random) { scene_ = (*random)() % scenes_.size(); }

std::vector<v1::Frame> ChangingHall::Look(int count) {
  std::vector<v1::Frame> frames;
  for (int i = 0; i < count; ++i, ++frames_) {
    frames.push_back(scenes_[scene_][frames_ % kLooks]);
    const double time_s = 1000.0 + 0.5 * static_cast<double>(frames_);
    *frames.back().mutable_capture_time() = ToProto(Timestamp::FromSeconds(time_s));
  }
  return frames;
}

}  // namespace steadymap

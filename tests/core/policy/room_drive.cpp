#include "tests/core/policy/room_drive.h"

#include <cmath>

#include "tests/core/policy/map_story.h"

namespace steadymap::testing {
namespace {

constexpr std::uint16_t kFloorClass = 1;
constexpr std::size_t kFirstBox = 3;
constexpr double kDriveSecondsPerFrame = 0.1;

}  // namespace

Scene Room() {
  return {Body(kFloorClass, {-4.0, -4.0, -0.1}, {4.0, 4.0, 0.0}),
          Body(kWallClass, {2.6, -3.0, 0.0}, {2.8, 2.6, 2.5}),
          Body(kWallClass, {-3.0, 2.6, 0.0}, {2.8, 2.8, 2.5}),
          Body(kGoodsClass, {1.8, -1.1, 0.0}, {2.2, -0.6, 0.8}),
          Body(kGoodsClass, {1.9, 0.2, 0.0}, {2.4, 0.6, 1.2}),
          Body(kGoodsClass, {0.9, 1.8, 0.0}, {1.4, 2.2, 0.6}),
          Body(kGoodsClass, {-0.6, 1.7, 0.0}, {-0.2, 2.1, 1.0})};
}

Scene RoomWithout(std::size_t count) {
  Scene scene = Room();
  const auto first = scene.begin() + static_cast<std::ptrdiff_t>(kFirstBox);
  scene.erase(first, first + static_cast<std::ptrdiff_t>(count));
  return scene;
}

SceneLook LookOf(int index) {
  const double yaw_rad = 0.5 + std::sin(0.1 * index);
  const Eigen::Vector3d eye_world(0.2 * std::sin(0.1 * index), 0.1 * std::cos(0.07 * index), 0.7);
  return {.eye_world = eye_world,
          .target_world = eye_world + Eigen::Vector3d(std::cos(yaw_rad), std::sin(yaw_rad), -0.15),
          .capture_time_s = 100.0 + kDriveSecondsPerFrame * index};
}

std::vector<Frame> Drive(const Scene& scene, int first, int count, double pause_s) {
  std::vector<Frame> frames;
  for (int i = first; i < first + count; ++i) {
    SceneLook look = LookOf(i);
    look.capture_time_s += pause_s;
    frames.push_back(RenderScene(scene, look));
  }
  return frames;
}

std::vector<Frame> Mislead(std::vector<Frame> frames, double shift_m, double turn_rad) {
  if (frames.empty()) return frames;
  const Eigen::Isometry3d& T_world_first = frames.front().T_world_camera;
  const Eigen::Translation3d here(T_world_first.translation());
  const Eigen::Vector3d left = -T_world_first.linear().col(0);
  const Eigen::Isometry3d misleading = Eigen::Translation3d(shift_m * left) * here *
                                       Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()) *
                                       here.inverse();
  for (Frame& frame : frames) frame.T_world_camera = misleading * frame.T_world_camera;
  return frames;
}

std::vector<Frame> From(const std::string& robot, std::vector<Frame> frames) {
  for (Frame& frame : frames) frame.source.robot = robot;
  return frames;
}

}  // namespace steadymap::testing

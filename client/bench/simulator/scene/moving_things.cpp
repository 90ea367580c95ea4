#include "client/bench/simulator/scene/moving_things.h"

#include <cmath>
#include <utility>

namespace steadymap {
namespace {

constexpr double kKeyPeriodS = 0.25;

}  // namespace

std::vector<MotionKey> MoveAlong(const GroundPath& path, const PathMotion& motion) {
  std::vector<MotionKey> keys;
  const Eigen::AngleAxisd about_turn(motion.speed_m_per_s < 0 ? M_PI : 0.0,
                                     Eigen::Vector3d::UnitZ());
  const int count = static_cast<int>(std::ceil(motion.duration_s / kKeyPeriodS));
  for (int i = 0; i <= count; ++i) {
    const double time_s = i * kKeyPeriodS;
    Eigen::Isometry3d pose = path.PoseAt(motion.start_m + motion.speed_m_per_s * time_s);
    pose.translation().z() = motion.height_m;
    pose.rotate(about_turn);
    keys.push_back({time_s, pose});
  }
  return keys;
}

MeshShape MakePersonShape() {
  return ShareMesh(MakeRevolvedMesh({{0.0, 0.0},
                                     {0.15, 0.02},
                                     {0.16, 0.80},
                                     {0.19, 1.00},
                                     {0.21, 1.38},
                                     {0.09, 1.50},
                                     {0.10, 1.56},
                                     {0.11, 1.65},
                                     {0.07, 1.73},
                                     {0.0, 1.75}},
                                    12));
}

MeshShape MakeForkliftShape() {
  TriangleMesh mesh;
  AppendBox({0.7, 0.8, 0.8}, {-0.3, 0, 0.45}, &mesh);
  AppendBox({0.06, 0.7, 1.85}, {0.1, 0, 0.97}, &mesh);
  AppendBox({0.5, 0.7, 0.06}, {-0.35, 0, 1.85}, &mesh);
  AppendBox({0.05, 0.05, 0.97}, {-0.6, 0.3, 1.335}, &mesh);
  AppendBox({0.05, 0.05, 0.97}, {-0.6, -0.3, 1.335}, &mesh);
  AppendBox({0.52, 0.12, 0.05}, {0.39, 0.2, 0.12}, &mesh);
  AppendBox({0.52, 0.12, 0.05}, {0.39, -0.2, 0.12}, &mesh);
  return ShareMesh(std::move(mesh));
}

MeshShape MakeToyCarShape() {
  TriangleMesh mesh;
  AppendBox({0.24, 0.11, 0.05}, {0, 0, 0.045}, &mesh);
  AppendBox({0.12, 0.095, 0.045}, {-0.015, 0, 0.0925}, &mesh);
  for (const double x_m : {-0.075, 0.075}) {
    for (const double y_m : {-0.05, 0.05}) AppendBox({0.04, 0.02, 0.04}, {x_m, y_m, 0.02}, &mesh);
  }
  return ShareMesh(std::move(mesh));
}

}  // namespace steadymap

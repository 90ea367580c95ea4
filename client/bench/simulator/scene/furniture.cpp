#include "client/bench/simulator/scene/furniture.h"

#include <utility>

namespace steadymap {
namespace {

constexpr int kSegments = 16;

/// Adds four posts from the ground up to `height_m` in the corners of a footprint.
void AppendLegs(const Eigen::Vector2d& footprint_m,
                double height_m,
                double thickness_m,
                TriangleMesh* mesh) {
  const Eigen::Vector2d corner = (footprint_m.array() - thickness_m) / 2;
  for (const double x_m : {-corner.x(), corner.x()}) {
    for (const double y_m : {-corner.y(), corner.y()}) {
      AppendBox({thickness_m, thickness_m, height_m}, {x_m, y_m, height_m / 2}, mesh);
    }
  }
}

}  // namespace

MeshShape MakeChairShape() {
  TriangleMesh mesh;
  AppendLegs({0.45, 0.45}, 0.43, 0.05, &mesh);
  AppendBox({0.45, 0.45, 0.04}, {0, 0, 0.45}, &mesh);
  AppendBox({0.04, 0.45, 0.43}, {-0.205, 0, 0.685}, &mesh);
  return ShareMesh(std::move(mesh));
}

MeshShape MakeTableShape(const Eigen::Vector3d& size_m) {
  constexpr double kBoardM = 0.04;
  TriangleMesh mesh;
  AppendLegs(size_m.head<2>(), size_m.z() - kBoardM, 0.06, &mesh);
  AppendBox({size_m.x(), size_m.y(), kBoardM}, {0, 0, size_m.z() - kBoardM / 2}, &mesh);
  return ShareMesh(std::move(mesh));
}

double ShelfBoardHeight(double height_m, int boards, int board) {
  constexpr double kLowestM = 0.1;
  return kLowestM + (height_m - kLowestM) * board / (boards - 1);
}

MeshShape MakeShelfShape(const Eigen::Vector3d& size_m, int boards) {
  constexpr double kBoardM = 0.03;
  TriangleMesh mesh;
  const double inner_m = size_m.y() - 2 * kBoardM;
  for (const double side : {-0.5, 0.5}) {
    AppendBox(
        {size_m.x(), kBoardM, size_m.z()}, {0, side * (inner_m + kBoardM), size_m.z() / 2}, &mesh);
  }
  for (int i = 0; i < boards; ++i) {
    const double middle_m = ShelfBoardHeight(size_m.z(), boards, i) - kBoardM / 2;
    AppendBox({size_m.x(), inner_m, kBoardM}, {0, 0, middle_m}, &mesh);
  }
  return ShareMesh(std::move(mesh));
}

MeshShape MakeCrateShape(const Eigen::Vector3d& size_m) {
  constexpr double kWallM = 0.03;
  TriangleMesh mesh;
  AppendBox({size_m.x(), size_m.y(), kWallM}, {0, 0, kWallM / 2}, &mesh);
  const double wall_height_m = size_m.z() - kWallM;
  const double wall_middle_m = kWallM + wall_height_m / 2;
  for (const double side : {-0.5, 0.5}) {
    AppendBox({kWallM, size_m.y(), wall_height_m},
              {side * (size_m.x() - kWallM), 0, wall_middle_m},
              &mesh);
    AppendBox({size_m.x() - 2 * kWallM, kWallM, wall_height_m},
              {0, side * (size_m.y() - kWallM), wall_middle_m},
              &mesh);
  }
  return ShareMesh(std::move(mesh));
}

MeshShape MakeBarrelShape(double radius_m, double height_m) {
  return ShareMesh(MakeRevolvedMesh({{0.0, 0.0},
                                     {radius_m * 0.9, 0.0},
                                     {radius_m, height_m * 0.3},
                                     {radius_m, height_m * 0.7},
                                     {radius_m * 0.9, height_m},
                                     {radius_m * 0.82, height_m},
                                     {radius_m * 0.82, height_m - 0.04},
                                     {0.0, height_m - 0.04}},
                                    kSegments));
}

MeshShape MakePlantShape(double height_m) {
  const double crown_m = height_m - 0.55;
  return ShareMesh(MakeRevolvedMesh({{0.0, 0.0},
                                     {0.12, 0.0},
                                     {0.17, 0.3},
                                     {0.14, 0.3},
                                     {0.03, 0.28},
                                     {0.03, 0.55},
                                     {0.2, 0.55 + 0.15 * crown_m},
                                     {0.25, 0.55 + 0.5 * crown_m},
                                     {0.15, 0.55 + 0.85 * crown_m},
                                     {0.0, height_m}},
                                    kSegments));
}

MeshShape MakeSackShape(double radius_m, double height_m) {
  return ShareMesh(MakeRevolvedMesh({{0.0, 0.0},
                                     {radius_m * 0.85, 0.0},
                                     {radius_m, height_m * 0.25},
                                     {radius_m * 0.8, height_m * 0.7},
                                     {radius_m * 0.3, height_m * 0.85},
                                     {radius_m * 0.4, height_m},
                                     {0.0, height_m * 0.97}},
                                    kSegments));
}

}  // namespace steadymap

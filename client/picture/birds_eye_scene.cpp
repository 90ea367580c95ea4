#include "client/picture/birds_eye_scene.h"

#include <algorithm>
#include <cmath>

namespace steadymap {
namespace {

constexpr double kLayerM = 0.1;
constexpr int kCeilingLayers = 4;
constexpr double kCeilingShare = 0.125;
constexpr double kClearanceM = 0.1;
// Bounds the memory; no building is this high.
constexpr int kMaxLayers = 10'000;

constexpr float kDownward = -0.7F;

// Share of vertices that the view may omit on each side, and that the ramp may saturate.
constexpr double kStrayShare = 0.0005;
constexpr double kHeightShare = 0.01;
constexpr double kMinHeightRangeM = 0.5;

constexpr double kBorderShare = 0.03;
constexpr double kMinBorderM = 0.25;

double HorizontalArea(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  const Eigen::Vector2f a = mesh.vertices_world[triangle[0]].head<2>();
  const Eigen::Vector2f ab = mesh.vertices_world[triangle[1]].head<2>() - a;
  const Eigen::Vector2f ac = mesh.vertices_world[triangle[2]].head<2>() - a;
  return 0.5 * std::abs(static_cast<double>(ab.x() * ac.y() - ab.y() * ac.x()));
}

bool IsFinite(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  return std::all_of(triangle.begin(), triangle.end(), [&mesh](std::uint32_t vertex) {
    return mesh.vertices_world[vertex].allFinite();
  });
}

// Returns the quantile `share` of the values; reorders them.
double Quantile(std::vector<float>* values, double share) {
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), values->begin() + rank, values->end());
  return static_cast<double>((*values)[static_cast<std::size_t>(rank)]);
}

// Returns the coordinates of the vertices of all drawn triangles, by axis.
std::array<std::vector<float>, 3> DrawnCoordinates(const Mesh& mesh, double cut_height_m) {
  std::vector<bool> drawn(mesh.vertices_world.size(), false);
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    if (!IsDrawnTopDown(mesh, triangle, cut_height_m)) continue;
    for (const std::uint32_t vertex : triangle) drawn[vertex] = true;
  }
  std::array<std::vector<float>, 3> coordinates;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    if (!drawn[i]) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      coordinates[axis].push_back(mesh.vertices_world[i][static_cast<Eigen::Index>(axis)]);
    }
  }
  return coordinates;
}

// Applies the rule of ChooseCutHeight to areas per layer, from `lowest_m` upwards.
std::optional<double> CutBelowCeiling(const std::vector<double>& downward_m2,
                                      double upward_m2,
                                      double lowest_m,
                                      double robots_m) {
  // Without upward-facing surface every layer would satisfy the area condition.
  if (upward_m2 <= 0.0) return std::nullopt;
  const int layers = static_cast<int>(downward_m2.size());
  for (int first = layers / 2; first < layers; ++first) {
    const double floor_m = lowest_m + first * kLayerM;
    if (floor_m < robots_m || downward_m2[static_cast<std::size_t>(first)] <= 0.0) continue;
    double area_m2 = 0.0;
    for (int i = first; i < std::min(first + kCeilingLayers, layers); ++i) {
      area_m2 += downward_m2[static_cast<std::size_t>(i)];
    }
    if (area_m2 >= kCeilingShare * upward_m2) return floor_m - kClearanceM;
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> ChooseCutHeight(const Mesh& mesh, const std::vector<RobotPath>& paths) {
  double robots_m = -std::numeric_limits<double>::infinity();
  for (const RobotPath& path : paths) {
    for (const Eigen::Vector3d& position : path.positions_world) {
      robots_m = std::max(robots_m, position.z());
    }
  }
  double lowest_m = std::numeric_limits<double>::infinity();
  double highest_m = -lowest_m;
  for (const Eigen::Vector3f& vertex : mesh.vertices_world) {
    if (!vertex.allFinite()) continue;
    lowest_m = std::min(lowest_m, static_cast<double>(vertex.z()));
    highest_m = std::max(highest_m, static_cast<double>(vertex.z()));
  }
  if (!(highest_m - lowest_m < kMaxLayers * kLayerM)) return std::nullopt;

  std::vector<double> downward_m2(static_cast<std::size_t>((highest_m - lowest_m) / kLayerM) + 1);
  double upward_m2 = 0.0;
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    if (!IsFinite(mesh, triangle)) continue;
    const float upward_cosine = UpwardCosine(mesh, triangle);
    if (upward_cosine > -kDownward) upward_m2 += HorizontalArea(mesh, triangle);
    if (upward_cosine >= kDownward) continue;
    const double height_m = static_cast<double>(mesh.vertices_world[triangle[0]].z());
    downward_m2[static_cast<std::size_t>((height_m - lowest_m) / kLayerM)] +=
        HorizontalArea(mesh, triangle);
  }
  return CutBelowCeiling(downward_m2, upward_m2, lowest_m, robots_m);
}

BirdsEyeScene ChooseScene(const Mesh& mesh,
                          const std::vector<RobotPath>& paths,
                          const BirdsEyeOptions& options) {
  BirdsEyeScene scene;
  const std::optional<double> cut_height_m =
      options.cut_height_m ? options.cut_height_m : ChooseCutHeight(mesh, paths);
  if (cut_height_m) scene.cut_height_m = *cut_height_m;
  std::array<std::vector<float>, 3> coordinates = DrawnCoordinates(mesh, scene.cut_height_m);
  scene.has_surface = !coordinates[0].empty();
  if (scene.has_surface) {
    for (const double share : {kStrayShare, 1.0 - kStrayShare}) {
      scene.extent_world.extend(
          Eigen::Vector2d(Quantile(&coordinates[0], share), Quantile(&coordinates[1], share)));
    }
    scene.lowest_m = Quantile(&coordinates[2], kHeightShare);
    scene.highest_m =
        std::max(Quantile(&coordinates[2], 1.0 - kHeightShare), scene.lowest_m + kMinHeightRangeM);
  }
  for (const RobotPath& path : paths) {
    for (const Eigen::Vector3d& position : path.positions_world) {
      if (position.allFinite()) scene.extent_world.extend(position.head<2>());
    }
  }
  if (scene.extent_world.isEmpty()) {
    scene.extent_world =
        Eigen::AlignedBox2d(Eigen::Vector2d(-5.0, -3.0), Eigen::Vector2d(5.0, 3.0));
  }
  const double border_m =
      std::max(kMinBorderM, kBorderShare * scene.extent_world.sizes().maxCoeff());
  scene.extent_world.min().array() -= border_m;
  scene.extent_world.max().array() += border_m;
  return scene;
}

}  // namespace steadymap

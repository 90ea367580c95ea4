#include "core/geometry/cuboid.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace steadymap {
namespace {

Eigen::Matrix2d PlanRotation(double yaw_rad) {
  return Eigen::Rotation2Dd(yaw_rad).toRotationMatrix();
}

/// Transforms a point of the xy plane to the frame of the box.
Eigen::Vector2d PlanInCuboid(const Cuboid& cuboid, const Eigen::Vector2d& point_world) {
  return PlanRotation(cuboid.yaw_rad).transpose() * (point_world - cuboid.center_world.head<2>());
}

double PlanDistance(const Cuboid& cuboid, const Eigen::Vector2d& point_world) {
  const Eigen::Vector2d beyond_m =
      PlanInCuboid(cuboid, point_world).cwiseAbs() - 0.5 * cuboid.size_m.head<2>();
  return beyond_m.cwiseMax(0.0).norm();
}

/// True if a line along a side of `a` separates the two bases.
bool SideSeparates(const Cuboid& a, const Cuboid& b) {
  Eigen::Vector2d low_m = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high_m = -low_m;
  for (const Eigen::Vector2d& corner_world : b.BaseCorners()) {
    const Eigen::Vector2d corner_m = PlanInCuboid(a, corner_world);
    low_m = low_m.cwiseMin(corner_m);
    high_m = high_m.cwiseMax(corner_m);
  }
  const Eigen::Vector2d half_m = 0.5 * a.size_m.head<2>();
  return (low_m.array() > half_m.array()).any() || (high_m.array() < -half_m.array()).any();
}

double PlanDistance(const Cuboid& a, const Cuboid& b) {
  if (!SideSeparates(a, b) && !SideSeparates(b, a)) return 0.0;
  // The nearest points of two separate convex polygons include a corner of one of them.
  double least_m = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& corner_world : a.BaseCorners()) {
    least_m = std::min(least_m, PlanDistance(b, corner_world));
  }
  for (const Eigen::Vector2d& corner_world : b.BaseCorners()) {
    least_m = std::min(least_m, PlanDistance(a, corner_world));
  }
  return least_m;
}

using Polygon = std::vector<Eigen::Vector2d>;

/// Returns the part of a convex polygon where `normal.dot(point) <= limit_m` (Sutherland and
/// Hodgman, 1974).
Polygon ClipToHalfPlane(const Polygon& polygon, const Eigen::Vector2d& normal, double limit_m) {
  Polygon clipped;
  clipped.reserve(polygon.size() + 1);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& from = polygon[i];
    const Eigen::Vector2d& to = polygon[(i + 1) % polygon.size()];
    const double from_beyond_m = normal.dot(from) - limit_m;
    const double to_beyond_m = normal.dot(to) - limit_m;
    if (from_beyond_m <= 0.0) clipped.push_back(from);
    if ((from_beyond_m <= 0.0) != (to_beyond_m <= 0.0)) {
      clipped.emplace_back(from + from_beyond_m / (from_beyond_m - to_beyond_m) * (to - from));
    }
  }
  return clipped;
}

/// Returns half the sum of the cross products of adjacent corners.
double Area(const Polygon& polygon) {
  double twice_m2 = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& from = polygon[i];
    const Eigen::Vector2d& to = polygon[(i + 1) % polygon.size()];
    twice_m2 += from.x() * to.y() - to.x() * from.y();
  }
  return std::max(0.0, 0.5 * twice_m2);
}

double PlanOverlapM2(const Cuboid& a, const Cuboid& b) {
  Polygon shared;
  for (const Eigen::Vector2d& corner_world : a.BaseCorners()) {
    shared.push_back(PlanInCuboid(b, corner_world));
  }
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d normal = Eigen::Vector2d::Unit(axis);
    shared = ClipToHalfPlane(shared, normal, 0.5 * b.size_m[axis]);
    shared = ClipToHalfPlane(shared, -normal, 0.5 * b.size_m[axis]);
  }
  return Area(shared);
}

/// Points in the xy plane, metres, one per column.
using PlanPoints = Eigen::Array<float, 2, Eigen::Dynamic, Eigen::RowMajor>;

// More points do not improve the estimate of the heading. To a degree, fewer tell it.
constexpr std::size_t kMaxHeadingPoints = 1024;
constexpr std::size_t kMaxCoarsePoints = 256;

// Share of the points beyond a side of the box by which a heading is judged, none of them farther
// than the margin. To find the sides themselves for each heading costs ten times as much.
constexpr double kShareBeyondHeading = 0.04;

// A point that is farther beyond a side does not tell the heading, as a share of the margin.
constexpr float kShareOfMarginBeyond = 0.25F;

/// Selects at most `max_count` evenly spaced points, relative to the first point.
PlanPoints ChoosePlanPoints(std::span<const Eigen::Vector3d> points_world, std::size_t max_count) {
  const std::size_t stride = (points_world.size() + max_count - 1) / max_count;
  const std::size_t count = (points_world.size() + stride - 1) / stride;
  PlanPoints points(2, static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d offset_m = points_world[i * stride] - points_world.front();
    points.col(static_cast<Eigen::Index>(i)) = offset_m.head<2>().cast<float>();
  }
  return points;
}

/// Returns the greatest of the positions below a limit; minus infinity if there is none.
double GreatestBelow(std::span<const double> positions_m, double limit_m) {
  double greatest_m = -std::numeric_limits<double>::infinity();
  for (const double at_m : positions_m) {
    if (at_m < limit_m && at_m > greatest_m) greatest_m = at_m;
  }
  return greatest_m;
}

std::size_t CountWithin(std::span<const double> positions_m, double low_m, double high_m) {
  const auto is_within = [=](double at_m) { return at_m >= low_m && at_m <= high_m; };
  return static_cast<std::size_t>(std::count_if(positions_m.begin(), positions_m.end(), is_within));
}

bool IsFewBeside(std::size_t count, std::size_t others, const CuboidMargin& margin) {
  return static_cast<double>(count) <= margin.max_share * static_cast<double>(others);
}

/// Returns the greatest of the positions that is not in an outer layer of a few stray points.
double GreatestButStrays(std::span<const double> positions_m, const CuboidMargin& margin) {
  double greatest_m = GreatestBelow(positions_m, std::numeric_limits<double>::infinity());
  while (margin.max_share > 0.0) {
    const double next_m = GreatestBelow(positions_m, greatest_m - margin.max_m);
    const std::size_t layer = CountWithin(positions_m, greatest_m - margin.max_m, greatest_m);
    const std::size_t next_layer = CountWithin(positions_m, next_m - margin.max_m, next_m);
    if (!IsFewBeside(layer, next_layer, margin)) break;
    greatest_m = next_m;
  }
  return greatest_m;
}

/// Returns the side of a cuboid at the high end of an axis, from the positions of the points along
/// it, metres.
double HighSide(std::span<const double> positions_m, const CuboidMargin& margin) {
  const double greatest_m = GreatestButStrays(positions_m, margin);
  if (margin.max_share <= 0.0) return greatest_m;
  std::vector<double> outer_m;
  for (const double at_m : positions_m) {
    if (at_m <= greatest_m && at_m >= greatest_m - 2 * margin.max_m) outer_m.push_back(at_m);
  }
  std::sort(outer_m.begin(), outer_m.end(), std::greater<>());
  double side_m = greatest_m;
  std::size_t end = 0;  // Of the points within the margin inside the side.
  for (std::size_t beyond = 0; beyond < outer_m.size(); ++beyond) {
    const double candidate_m = outer_m[beyond];
    if (candidate_m < greatest_m - margin.max_m) break;
    while (end < outer_m.size() && outer_m[end] >= candidate_m - margin.max_m) ++end;
    if (IsFewBeside(beyond, end - beyond, margin)) side_m = candidate_m;
  }
  return side_m;
}

/// Returns the side of a box by which a heading is judged, in direction `sign` (1 or -1), as a
/// multiple of `sign`. Reorders the points, which are given by their positions along an axis,
/// metres.
float HighHeadingSide(float sign, float max_m, std::span<float> along_m) {
  const auto beyond =
      static_cast<std::ptrdiff_t>(kShareBeyondHeading * static_cast<double>(along_m.size() - 1));
  const auto side = along_m.begin() + beyond;
  const auto is_farther = [sign](float a, float b) { return sign * a > sign * b; };
  std::nth_element(along_m.begin(), side, along_m.end(), is_farther);
  const float farthest_m = sign * *std::min_element(along_m.begin(), side + 1, is_farther);
  return std::max(sign * *side, farthest_m - max_m);
}

/// Two parallel sides, by their positions along the axis across them, metres.
struct Sides {
  float low_m = 0.0F;
  float high_m = 0.0F;
};

/// Returns the sides by which a heading is judged, from the positions of points along an axis.
Sides FindHeadingSides(const Eigen::ArrayXf& along_m, const CuboidMargin& margin) {
  if (margin.max_share <= 0.0) return {along_m.minCoeff(), along_m.maxCoeff()};
  Eigen::ArrayXf reordered = along_m;
  const std::span<float> span(reordered.data(), static_cast<std::size_t>(reordered.size()));
  const auto max_m = static_cast<float>(margin.max_m);
  const float high_m = HighHeadingSide(1.0F, max_m, span);
  return {-HighHeadingSide(-1.0F, max_m, span), high_m};
}

/// Returns the distances of points, given by their positions along an axis, from the nearer one of
/// the two sides across it, metres.
Eigen::ArrayXf DistancesFromSides(const Eigen::ArrayXf& along_m, const CuboidMargin& margin) {
  const Sides sides = FindHeadingSides(along_m, margin);
  return (along_m - sides.low_m).abs().min((sides.high_m - along_m).abs());
}

/// Returns the points turned by `-yaw_rad`.
PlanPoints TurnBack(const PlanPoints& points, double yaw_rad) {
  const auto cosine = static_cast<float>(std::cos(yaw_rad));
  const auto sine = static_cast<float>(std::sin(yaw_rad));
  PlanPoints turned(2, points.cols());
  turned.row(0) = cosine * points.row(0) + sine * points.row(1);
  turned.row(1) = cosine * points.row(1) - sine * points.row(0);
  return turned;
}

/// Returns the mean distance of the points from the nearest side of their rectangle of the given
/// heading, metres.
double MeanDistanceFromSides(const PlanPoints& points, double yaw_rad, const CuboidMargin& margin) {
  const PlanPoints turned = TurnBack(points, yaw_rad);
  const Eigen::ArrayXf x = turned.row(0);
  const Eigen::ArrayXf y = turned.row(1);
  return static_cast<double>(
      DistancesFromSides(x, margin).min(DistancesFromSides(y, margin)).mean());
}

/// Returns the points that are not beyond the sides of the rectangle of `coarse` of that heading.
PlanPoints WithoutPointsBeyond(const PlanPoints& points,
                               const PlanPoints& coarse,
                               double yaw_rad,
                               const CuboidMargin& margin) {
  const float limit_m = kShareOfMarginBeyond * static_cast<float>(margin.max_m);
  const PlanPoints turned = TurnBack(points, yaw_rad);
  const PlanPoints turned_coarse = TurnBack(coarse, yaw_rad);
  const Sides x = FindHeadingSides(turned_coarse.row(0), margin);
  const Sides y = FindHeadingSides(turned_coarse.row(1), margin);
  PlanPoints kept(2, points.cols());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (turned(0, i) < x.low_m - limit_m || turned(0, i) > x.high_m + limit_m ||
        turned(1, i) < y.low_m - limit_m || turned(1, i) > y.high_m + limit_m) {
      continue;
    }
    kept.col(count++) = points.col(i);
  }
  kept.conservativeResize(2, count);
  return kept;
}

/// Returns the best of `count` headings, from `first_rad` on in steps of `step_rad`.
double FindBestHeading(const PlanPoints& points,
                       const CuboidMargin& margin,
                       double first_rad,
                       double step_rad,
                       int count) {
  double best_rad = first_rad;
  double least_m = std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i) {
    const double yaw_rad = first_rad + i * step_rad;
    const double distance_m = MeanDistanceFromSides(points, yaw_rad, margin);
    if (distance_m >= least_m) continue;
    best_rad = yaw_rad;
    least_m = distance_m;
  }
  return best_rad;
}

/// Returns the heading of one of the sides, with an error of an eighth of a degree.
double FindSideYaw(std::span<const Eigen::Vector3d> points_world, const CuboidMargin& margin) {
  if (points_world.size() < 2) return 0.0;
  constexpr double kDegree = std::numbers::pi / 180.0;
  const bool has_margin = margin.max_share > 0.0;
  const PlanPoints points = ChoosePlanPoints(points_world, kMaxHeadingPoints);
  // A margin costs much more time for many points.
  const PlanPoints coarse = has_margin ? ChoosePlanPoints(points_world, kMaxCoarsePoints) : points;
  double yaw_rad = FindBestHeading(coarse, margin, 0.0, 5.0 * kDegree, 18);
  yaw_rad = FindBestHeading(coarse, margin, yaw_rad - 4.0 * kDegree, kDegree, 9);
  const PlanPoints kept =
      has_margin ? WithoutPointsBeyond(points, coarse, yaw_rad, margin) : points;
  if (kept.cols() == 0) return yaw_rad;
  return FindBestHeading(kept, {}, yaw_rad - 0.75 * kDegree, 0.25 * kDegree, 7);
}

}  // namespace

Eigen::Isometry3d Cuboid::T_world_cuboid() const {
  Eigen::Isometry3d T_world_cuboid = Eigen::Isometry3d::Identity();
  T_world_cuboid.translation() = center_world;
  T_world_cuboid.linear().topLeftCorner<2, 2>() = PlanRotation(yaw_rad);
  return T_world_cuboid;
}

std::array<Eigen::Vector2d, 4> Cuboid::BaseCorners() const {
  const Eigen::Matrix2d R_world_cuboid = PlanRotation(yaw_rad);
  const Eigen::Vector2d along_m = R_world_cuboid.col(0) * (0.5 * size_m.x());
  const Eigen::Vector2d across_m = R_world_cuboid.col(1) * (0.5 * size_m.y());
  const Eigen::Vector2d center = center_world.head<2>();
  return {center - along_m - across_m,
          center + along_m - across_m,
          center + along_m + across_m,
          center - along_m + across_m};
}

double DistanceTo(const Cuboid& cuboid, const Eigen::Vector3d& point_world) {
  const double above_m = point_world.z() - cuboid.highest_m();
  const double below_m = cuboid.lowest_m() - point_world.z();
  return std::hypot(PlanDistance(cuboid, point_world.head<2>()), std::max({0.0, above_m, below_m}));
}

double DistanceBetween(const Cuboid& a, const Cuboid& b) {
  const double above_m = a.lowest_m() - b.highest_m();
  const double below_m = b.lowest_m() - a.highest_m();
  return std::hypot(PlanDistance(a, b), std::max({0.0, above_m, below_m}));
}

double OverlapM3(const Cuboid& a, const Cuboid& b) {
  const double shared_height_m =
      std::min(a.highest_m(), b.highest_m()) - std::max(a.lowest_m(), b.lowest_m());
  if (shared_height_m <= 0.0) return 0.0;
  return shared_height_m * PlanOverlapM2(a, b);
}

Cuboid FitCuboid(std::span<const Eigen::Vector3d> points_world, const CuboidMargin& margin) {
  const double yaw_rad = FindSideYaw(points_world, margin);
  Cuboid cuboid = FitCuboid(points_world, yaw_rad, margin);
  if (cuboid.size_m.x() >= cuboid.size_m.y()) return cuboid;
  const double quarter_turn_rad = 0.5 * std::numbers::pi;
  return FitCuboid(points_world,
                   yaw_rad > 0.0 ? yaw_rad - quarter_turn_rad : yaw_rad + quarter_turn_rad,
                   margin);
}

Cuboid FitCuboid(std::span<const Eigen::Vector3d> points_world,
                 double yaw_rad,
                 const CuboidMargin& margin) {
  Cuboid cuboid;
  cuboid.yaw_rad = yaw_rad;
  if (points_world.empty()) return cuboid;
  // Offsets are relative to a point of the set. Relative to a distant origin they would lose
  // digits.
  const Eigen::Vector3d& reference_world = points_world.front();
  Eigen::Matrix3d R_world_cuboid = Eigen::Matrix3d::Identity();
  R_world_cuboid.topLeftCorner<2, 2>() = PlanRotation(yaw_rad);
  Eigen::Vector3d low_m;
  Eigen::Vector3d high_m;
  std::vector<double> offsets_m(points_world.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < points_world.size(); ++i) {
      offsets_m[i] = R_world_cuboid.col(axis).dot(points_world[i] - reference_world);
    }
    high_m[axis] = HighSide(offsets_m, margin);
    for (double& offset_m : offsets_m) offset_m = -offset_m;
    low_m[axis] = -HighSide(offsets_m, axis < 2 ? margin : CuboidMargin());
  }
  cuboid.center_world = reference_world + R_world_cuboid * (0.5 * (low_m + high_m));
  cuboid.size_m = (high_m - low_m).cwiseMax(0.0);
  return cuboid;
}

Cuboid MajorAxisCuboid(std::span<const Eigen::Vector3d> points_world) {
  if (points_world.empty()) return {};
  const auto count = static_cast<double>(points_world.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& point : points_world) mean += point.head<2>() / count;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector3d& point : points_world) {
    const Eigen::Vector2d arm = point.head<2>() - mean;
    covariance += arm * arm.transpose() / count;
  }
  const Eigen::Vector2d axis =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvectors().col(1);
  return FitCuboid(points_world, std::atan2(axis.y(), axis.x()));
}

}  // namespace steadymap

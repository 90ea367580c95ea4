#include "core/objects/outline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/objects/point_grid.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// Outlines are judged in cubes of this size, metres, or of a voxel if that is larger: smaller ones
// follow the noise.
constexpr double kMinGrainM = 0.04;

// A surface goes on in a direction if there is more of it so many cubes away. The space beside its
// outline is looked at one cube further.
constexpr double kNextGrains = 2.0;
constexpr int kBesideGrains = 3;

// A surface that is thinner is flat, cubes: noise and the rounding of voxels explain its thickness.
constexpr double kFlatGrains = 2.0;

/// The way from a point of one surface to the nearest one of another.
struct Gap {
  const OrientedPoint* from = nullptr;
  const OrientedPoint* to = nullptr;
  double width_m = 0.0;
};

}  // namespace

OutlineTest::OutlineTest(const WorkingMap& map, std::span<const Eigen::Vector3d> structure_world)
    : map_(map),
      grain_m_(std::max(kMinGrainM, map.scale().voxel_size_m)),
      structure_(CellsOf(structure_world)) {}

std::set<OutlineTest::Cell> OutlineTest::CellsOf(
    std::span<const Eigen::Vector3d> points_world) const {
  std::set<Cell> cells;
  for (const Eigen::Vector3d& point : points_world) cells.insert(CellOf(point));
  return cells;
}

OutlineTest::Cell OutlineTest::CellOf(const Eigen::Vector3d& point_world) const {
  const Eigen::Vector3i cell = (point_world / grain_m_).array().round().cast<int>();
  return {cell.x(), cell.y(), cell.z()};
}

/// True if `cells` contains a cell or one of its 26 neighbours.
bool OutlineTest::HasNeighbour(const std::set<Cell>& cells, const Cell& cell) {
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (cells.contains({cell[0] + x, cell[1] + y, cell[2] + z})) return true;
      }
    }
  }
  return false;
}

/// True if the background was measured around a point. Voxels behind a silhouette, extrapolated
/// from the surface beside it, are no structure.
bool OutlineTest::IsOnStructure(const Eigen::Vector3d& point_world) const {
  if (HasNeighbour(structure_, CellOf(point_world))) return true;
  return TsdfSampler(map_.background(), map_.scale()).IsMeasured(point_world);
}

/// Finds the outline of a surface. The space beside it is looked at `behind_m` behind the surface.
OutlineTest::Outline OutlineTest::OutlineOf(std::span<const OrientedPoint> surface,
                                            double behind_m) const {
  std::set<Cell> cells;
  for (const OrientedPoint& point : surface) cells.insert(CellOf(point.position_world));
  const bool is_flat = IsFlat(surface);
  Outline outline;
  for (const OrientedPoint& point : surface) {
    const Eigen::Vector3d along = point.normal_world.unitOrthogonal();
    const Eigen::Vector3d across = point.normal_world.cross(along);
    for (const Eigen::Vector3d& direction : {along, across}) {
      for (const double sign : {-1.0, 1.0}) {
        const Eigen::Vector3d step = sign * grain_m_ * direction;
        if (GoesOn(cells, is_flat, point, step)) continue;
        const Eigen::Vector3d beside_world =
            point.position_world + kBesideGrains * step - behind_m * point.normal_world;
        AddPlace(point.position_world, step, beside_world, &outline);
      }
    }
  }
  return outline;
}

/// True if a surface goes on from a point in the direction of `step`. A flat one does so straight
/// ahead: beside that, it has cells along a slanting outline, too.
bool OutlineTest::GoesOn(const std::set<Cell>& cells,
                         bool is_flat,
                         const OrientedPoint& point,
                         const Eigen::Vector3d& step) const {
  if (!is_flat) return HasNeighbour(cells, CellOf(point.position_world + kNextGrains * step));
  for (int ahead = 1; ahead <= kBesideGrains; ++ahead) {
    for (int above = -1; above <= 1; ++above) {
      if (cells.contains(CellOf(point.position_world + ahead * step +
                                above * grain_m_ * point.normal_world))) {
        return true;
      }
    }
  }
  return false;
}

/// Counts a place of an outline by what is beside it, in the direction of `step`.
void OutlineTest::AddPlace(const Eigen::Vector3d& point_world,
                           const Eigen::Vector3d& step,
                           const Eigen::Vector3d& beside_world,
                           Outline* outline) const {
  if (MeetsStructure(point_world, step)) {
    ++outline->at_structure;
  } else if (map_.free_space().IsFree(beside_world)) {
    ++outline->beside_free_space;
  } else {
    ++outline->unseen;
  }
}

/// True if structure is beside a place of an outline, or a few steps away: nobody looks into the
/// gap between a thing and a wall closely behind it.
bool OutlineTest::MeetsStructure(const Eigen::Vector3d& point_world,
                                 const Eigen::Vector3d& step) const {
  for (int grains = 1; grains <= kBesideGrains; ++grains) {
    if (IsOnStructure(point_world + grains * step)) return true;
  }
  return false;
}

bool OutlineTest::IsFlat(std::span<const OrientedPoint> surface) const {
  return PrincipalAxesOf(surface).lengths_m.z() < kFlatGrains * grain_m_;
}

double OutlineTest::UnseenShareOf(std::span<const OrientedPoint> surface) const {
  if (surface.empty()) return 0.0;
  const Outline outline = OutlineOf(surface, 0.0);
  // Each point stands for the square of a voxel. The points within a cube of an edge are beside it.
  const double point_m2 = map_.scale().voxel_size_m * map_.scale().voxel_size_m;
  const auto length_of = [&](std::size_t places) {
    return static_cast<double>(places) * point_m2 / grain_m_;
  };
  const double unseen_m = length_of(outline.unseen);
  const double seen_m = length_of(outline.beside_free_space);
  double shortest_m = 2.0 * std::sqrt(M_PI * point_m2 * static_cast<double>(surface.size()));
  if (IsFlat(surface)) {
    shortest_m -= length_of(outline.at_structure);
  }
  const double length_m = std::max(unseen_m + seen_m, shortest_m);
  return length_m > 0.0 ? unseen_m / length_m : 0.0;
}

double OutlineTest::FreeShareOf(std::span<const OrientedPoint> surface) const {
  // Cells of free space that touch a floor or a wall reach behind it.
  const Outline outline = OutlineOf(surface, map_.free_space().cell_size_m());
  const std::size_t length = outline.at_structure + outline.beside_free_space + outline.unseen;
  if (length == 0) return 0.0;
  return static_cast<double>(outline.beside_free_space) / static_cast<double>(length);
}

bool OutlineTest::HasUnseenEnd(std::span<const OrientedPoint> surface,
                               std::span<const Eigen::Vector3d> continuation_world) const {
  const Eigen::Vector3d axis = PrincipalAxesOf(surface).axes.col(0);
  for (const Eigen::Vector3d& outward : {axis, Eigen::Vector3d(-axis)}) {
    double end_m = std::numeric_limits<double>::lowest();
    for (const OrientedPoint& point : surface) {
      end_m = std::max(end_m, outward.dot(point.position_world));
    }
    std::set<Cell> continuation;
    for (const Eigen::Vector3d& point : continuation_world) {
      if (outward.dot(point) > end_m) continuation.insert(CellOf(point));
    }
    std::size_t unseen = 0;
    std::size_t count = 0;
    for (const OrientedPoint& point : surface) {
      if (outward.dot(point.position_world) < end_m - grain_m_) continue;
      ++count;
      const Eigen::Vector3d beyond = point.position_world + grain_m_ * outward;
      const bool goes_on = HasNeighbour(continuation, CellOf(beyond));
      const bool ends =
          IsOnStructure(beyond) ||
          map_.free_space().IsFree(point.position_world + kBesideGrains * grain_m_ * outward);
      if (goes_on || !ends) ++unseen;
    }
    if (2 * unseen >= count) return true;
  }
  return false;
}

bool OutlineTest::MayGoOnAs(std::span<const OrientedPoint> surface,
                            std::span<const OrientedPoint> other,
                            double max_gap_m) const {
  const PointGrid grid(other, max_gap_m);
  std::vector<Gap> gaps;
  double smallest_m = max_gap_m;
  for (const OrientedPoint& point : surface) {
    std::size_t nearest = 0;
    double nearest_m = std::numeric_limits<double>::max();
    grid.ForEachNear(point.position_world, [&](std::size_t i) {
      const double distance_m = (other[i].position_world - point.position_world).norm();
      if (distance_m >= nearest_m) return;
      nearest = i;
      nearest_m = distance_m;
    });
    if (nearest_m > max_gap_m) continue;
    gaps.push_back({&point, &other[nearest], nearest_m});
    smallest_m = std::min(smallest_m, nearest_m);
  }
  std::size_t seen = 0;
  std::size_t count = 0;
  for (const Gap& gap : gaps) {
    if (gap.width_m > smallest_m + kNextGrains * grain_m_) continue;
    ++count;
    // Cells of free space that touch a surface reach behind it.
    if (IsSeenBetween(gap.from->position_world, gap.to->position_world) &&
        IsSeenBetween(Behind(*gap.from), Behind(*gap.to))) {
      ++seen;
    }
  }
  return count > 0 && 2 * seen < count;
}

/// Returns the point of the same height behind a surface, outside the cells of free space that
/// touch it: gaps are between things that stand beside each other.
Eigen::Vector3d OutlineTest::Behind(const OrientedPoint& point) const {
  const Eigen::Vector3d sideways(point.normal_world.x(), point.normal_world.y(), 0.0);
  return point.position_world - map_.free_space().cell_size_m() * sideways;
}

/// True if on the way between two points of surfaces, free space was seen, or structure: a floor
/// between two things shows that they end there.
bool OutlineTest::IsSeenBetween(const Eigen::Vector3d& from_world,
                                const Eigen::Vector3d& to_world) const {
  const double length_m = (to_world - from_world).norm();
  const Eigen::Vector3d direction = (to_world - from_world) / length_m;
  const int grains = static_cast<int>(length_m / grain_m_);
  for (int i = 1; i < grains; ++i) {
    const Eigen::Vector3d point_world = from_world + i * grain_m_ * direction;
    if (map_.free_space().IsFree(point_world) || IsOnStructure(point_world)) return true;
  }
  return false;
}

}  // namespace steadymap

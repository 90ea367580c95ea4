#pragma once

#include <array>
#include <cstddef>
#include <set>
#include <span>

#include <Eigen/Core>

#include "core/objects/surface_parts.h"
#include "core/working/working_map.h"

namespace steadymap {

/// Tells whether the whole side of an object that faces the cameras was seen: then its outline
/// adjoins free space, except where it meets the background. Where it is unknown, the object may go
/// on behind another one or beyond the range of the camera.
class OutlineTest {
 public:
  /// `structure_world` are points of floors and walls that are not in the background yet, metres.
  /// The map must outlive the test.
  OutlineTest(const WorkingMap& map, std::span<const Eigen::Vector3d> structure_world);

  /// Returns the share of the outline of a surface beside which the space is not known to be free,
  /// in [0, 1]; what ends at structure does not count. The outline counts as at least so long as
  /// that of a disc of the same area, the shortest of a flat surface: a surface that was seen from
  /// all sides has hardly any. Where a flat surface ends at structure, that much of the disc's does
  /// not count either.
  double UnseenShareOf(std::span<const OrientedPoint> surface) const;

  /// Returns the share of the outline of a surface beside which the space is free, also behind the
  /// surface, in [0, 1]; 0 if it has no outline.
  double FreeShareOf(std::span<const OrientedPoint> surface) const;

  /// True if a slender surface has an end that was not seen: what is beyond at least half of it is
  /// neither free space nor structure, or is one of `continuation_world`, points of what it may go
  /// on as, metres. Points that are not beyond the end tell nothing.
  bool HasUnseenEnd(std::span<const OrientedPoint> surface,
                    std::span<const Eigen::Vector3d> continuation_world) const;

  /// True if a surface may go on as `other`: most of what is nearest to it, within `max_gap_m`, has
  /// neither free space nor structure in between.
  bool MayGoOnAs(std::span<const OrientedPoint> surface,
                 std::span<const OrientedPoint> other,
                 double max_gap_m) const;

 private:
  using Cell = std::array<int, 3>;

  /// Places of an outline, by what is beside them.
  struct Outline {
    std::size_t at_structure = 0;  ///< It ends there in any case.
    std::size_t beside_free_space = 0;
    std::size_t unseen = 0;
  };

  Outline OutlineOf(std::span<const OrientedPoint> surface, double behind_m) const;
  bool GoesOn(const std::set<Cell>& cells,
              bool is_flat,
              const OrientedPoint& point,
              const Eigen::Vector3d& step) const;
  void AddPlace(const Eigen::Vector3d& point_world,
                const Eigen::Vector3d& step,
                const Eigen::Vector3d& beside_world,
                Outline* outline) const;
  bool IsFlat(std::span<const OrientedPoint> surface) const;
  bool MeetsStructure(const Eigen::Vector3d& point_world, const Eigen::Vector3d& step) const;

  Cell CellOf(const Eigen::Vector3d& point_world) const;
  std::set<Cell> CellsOf(std::span<const Eigen::Vector3d> points_world) const;
  static bool HasNeighbour(const std::set<Cell>& cells, const Cell& cell);
  Eigen::Vector3d Behind(const OrientedPoint& point) const;
  bool IsSeenBetween(const Eigen::Vector3d& from_world, const Eigen::Vector3d& to_world) const;
  bool IsOnStructure(const Eigen::Vector3d& point_world) const;

  const WorkingMap& map_;
  double grain_m_;
  std::set<Cell> structure_;
};

}  // namespace steadymap

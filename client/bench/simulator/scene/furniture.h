#pragma once

#include "client/bench/simulator/scene/shape.h"

/// Shapes of furniture and goods. The base of each shape is at z = 0 of its object's frame, centred
/// on the z axis, with the front towards +x.
namespace steadymap {

/// Seat, back and four legs, 0.45 x 0.45 x 0.9 m.
MeshShape MakeChairShape();

/// A board 4 cm thick on four legs. `size_m`: length (x), depth (y), height, each > 0.2.
MeshShape MakeTableShape(const Eigen::Vector3d& size_m);

/// Boards between two sides, open at the front and the back. `size_m`: depth (x), width (y),
/// height; `boards` >= 2.
MeshShape MakeShelfShape(const Eigen::Vector3d& size_m, int boards);

/// Returns the height of the top of board `board` (from 0) of a shelf: 10 cm for the lowest,
/// `height_m` for the highest.
double ShelfBoardHeight(double height_m, int boards, int board);

/// A box without a lid, 3 cm thick. `size_m`: outer side lengths, each > 0.1.
MeshShape MakeCrateShape(const Eigen::Vector3d& size_m);

/// An upright cylinder with a rim.
MeshShape MakeBarrelShape(double radius_m, double height_m);

/// A pot with a round crown on a stem, 0.5 m wide and `height_m` (> 0.6) high.
MeshShape MakePlantShape(double height_m);

/// A bulging sack.
MeshShape MakeSackShape(double radius_m, double height_m);

}  // namespace steadymap

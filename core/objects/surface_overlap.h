#pragma once

#include <Eigen/Geometry>

#include "core/map/pose_error.h"
#include "core/volume/background.h"
#include "core/volume/free_space.h"
#include "core/working/tracked_object.h"

namespace steadymap {

/// When two looks are at one surface.
struct SurfaceMatchParameters {
  /// Their distance before the registration of the looks, voxels. Surfaces of one look that are
  /// closer are in contact.
  double contact_voxels = 1.5;
  /// Largest angle between their normals, as a cosine.
  double min_normal_cosine = 0.5;
  /// Their distance after registration, in standard deviations of `SurfaceSigmaM`.
  double max_sigmas = 3.0;
  /// Standard deviation of the place of an object that nobody moved, metres, and of a surface in
  /// its voxels, voxels.
  double place_sigma_m = kPlaceSigmaM;
  double surface_sigma_voxels = 0.1;

  friend bool operator==(const SurfaceMatchParameters&, const SurfaceMatchParameters&) = default;
};

/// How the surface of one object agrees with another object.
struct SurfaceOverlap {
  double known_share = 0.0;  ///< Share of the points in what the other has observed.
  double fit_share = 0.0;    ///< Of those, the share on its surface, facing the same way.
  double close_share = 0.0;  ///< Of those, the share on it within the error of two looks.

  /// Returns the share of all points that are known to be on the surface.
  double known_fit_share() const { return known_share * fit_share; }

  /// Returns the share of all points that are known to be on it within the error of two looks.
  double known_close_share() const { return known_share * close_share; }

  /// Returns the expected share of all points on the surface within the error of two looks, if a
  /// point of which nothing is known is on it with a probability of `odds`.
  double expected_share(double odds) const {
    return known_close_share() + odds * (1.0 - known_share);
  }
};

/// How the surfaces of two objects agree, each compared with the volume of the other one.
struct MutualOverlap {
  SurfaceOverlap overlap;
  SurfaceOverlap reverse_overlap;

  /// Returns the share of what is known of a surface that agrees within the error of two looks,
  /// averaged over both surfaces, in [0, 1].
  double close_share() const { return 0.5 * (overlap.close_share + reverse_overlap.close_share); }

  /// Returns the same, averaged over both surfaces.
  double expected_share(double odds) const {
    return 0.5 * (overlap.expected_share(odds) + reverse_overlap.expected_share(odds));
  }
};

/// Returns the standard deviation of the distance between two looks at one surface in place,
/// metres: the error of registered frames, and that of voxels.
double SurfaceSigmaM(const SurfaceMatchParameters& parameters, const VoxelScale& scale);

/// Compares the surface of `object`, moved by `T_other_object`, with the volume of `other`. A point
/// is on the surface within `contact_voxels`, and close to it within `max_sigmas`. Zeros for an
/// object without surface. With `free_space` around `other` where it stands, it is known that the
/// other one has no surface in free space; without (null), what its volume has not observed is
/// unknown.
SurfaceOverlap CompareSurfaces(const TrackedObject& object,
                               const TrackedObject& other,
                               const Eigen::Isometry3d& T_other_object,
                               const SurfaceMatchParameters& parameters,
                               const VoxelScale& scale,
                               const FreeSpaceSince* free_space = nullptr);

/// Compares the surface of `object`, where it stands, with the background in the same way.
SurfaceOverlap CompareWithBackground(const TrackedObject& object,
                                     const Background& background,
                                     const SurfaceMatchParameters& parameters,
                                     const VoxelScale& scale);

/// Compares the surfaces of two objects where they stand. `free_space` around `a`, if it is known.
/// Surface that lies behind that of the other object and faces another way counts as unknown: it
/// may be the far side of a thing that is thinner than the truncation distance.
MutualOverlap CompareInPlace(const TrackedObject& a,
                             const TrackedObject& b,
                             const SurfaceMatchParameters& parameters,
                             const VoxelScale& scale,
                             const FreeSpaceSince* free_space = nullptr);

}  // namespace steadymap

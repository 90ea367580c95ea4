#pragma once

#include <optional>

namespace steadymap {

/// How the change between an object and its observation is measured.
struct ChangeParameters {
  /// Factor on the mean difference (lambda_diff), > 0. Default: TorWIC (Qian et al., RSS 2022).
  double change_scale = 1.6;
  /// Distances are clamped to this, and what is further than it in front of both surfaces is not
  /// compared, metres, > 0. No change exceeds half of it times `change_scale`, however far a thing
  /// has moved. Infinity: nothing is clamped.
  double truncation_m = 0.15;

  friend bool operator==(const ChangeParameters&, const ChangeParameters&) = default;
};

/// Sums the rays of one camera into the magnitude of the geometric change between an object and its
/// observation (core/README.md#change-estimate):
///
///     |delta| = change_scale / |Omega| * sum over Omega of |observed distance - object distance|
///
/// Distances are those of the two projective TSDFs: along the camera's z axis from a voxel to the
/// surface behind it. Omega holds the voxels where both are positive. Those of one ray lie between
/// the camera and the nearer of its two depths, and are the denser the larger the cone of the ray,
/// so the sum over them is an integral of `z^2` and depends on the two depths alone.
class ChangeSum {
 public:
  explicit ChangeSum(const ChangeParameters& parameters) : parameters_(parameters) {}

  /// Adds a ray by its two depths, metres. A depth that is not positive and finite says that
  /// nothing is there: such a ray has no voxel in Omega.
  void AddRay(double object_depth_m, double observed_depth_m);

  /// The magnitude of the change, metres; none if Omega is empty. Noise adds to it: the change of
  /// what stands still is not zero.
  std::optional<double> Change() const;

 private:
  ChangeParameters parameters_;
  // Sums over the voxels of Omega, in units of the voxels of a unit volume.
  double voxels_ = 0.0;
  double difference_ = 0.0;  ///< Of |observed distance - object distance|.
};

}  // namespace steadymap

#include "core/objects/session_alignment.h"

#include <algorithm>
#include <cmath>

#include "core/objects/session_parts.h"
#include "core/objects/surface_overlap.h"
#include "core/registration/anchored_alignment.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// Points of a thing that take part in the alignment of a session.
constexpr std::size_t kMaxAnchorPoints = 400;

AnchorMatches MatchesOf(const TrackedObject& seen,
                        const TrackedObject& known,
                        const Eigen::Isometry3d& T_correction,
                        const VoxelScale& scale) {
  const Eigen::Isometry3d T_world_known = known.state().T_world_object.ToIsometry();
  const Eigen::Isometry3d T_known_world = T_world_known.inverse();
  TsdfSampler sampler(known.volume(), scale);
  const std::vector<Eigen::Vector3d> points_world = seen.SurfaceInWorld();
  const std::size_t stride = points_world.size() / kMaxAnchorPoints + 1;
  AnchorMatches matches;
  for (std::size_t i = 0; i < points_world.size(); i += stride) {
    const Eigen::Vector3d moved_world = T_correction * points_world[i];
    const DistanceSample sample = sampler.Sample(T_known_world * moved_world);
    if (!sample.known || std::abs(sample.distance_m) > scale.voxel_size_m) continue;
    const Eigen::Vector3d normal_world = T_world_known.linear() * sample.gradient;
    matches.push_back(
        {points_world[i], moved_world - sample.distance_m * normal_world, normal_world});
  }
  return matches;
}

/// Returns how far an object that was shifted and turned is from its place in the plan, metres.
double DisplacementOf(const Eigen::Vector3d& shift_world,
                      double yaw_rad,
                      const TrackedObject& object) {
  const double radius_m = 0.5 * object.cuboid().size_m.head<2>().norm();
  return std::hypot(shift_world.head<2>().norm(), yaw_rad * radius_m);
}

/// Returns the offset that an alignment found. Where the anchors tell nothing, its covariance is
/// that of poses which are off by `max_offset_m` at three standard deviations.
PoseOffset OffsetOf(const AnchorAlignment& alignment, double anchor_sigma_m, double max_offset_m) {
  const double prior_sigma_m = max_offset_m / 3.0;
  Eigen::Vector4d prior_information =
      Eigen::Vector4d::Constant(1.0 / (prior_sigma_m * prior_sigma_m));
  prior_information[3] *= alignment.lever_m * alignment.lever_m;
  Eigen::Matrix4d information = alignment.information / (anchor_sigma_m * anchor_sigma_m);
  information += prior_information.asDiagonal();
  PoseOffset offset;
  offset.center_world = alignment.center_world;
  offset.shift_world = alignment.motion * alignment.center_world - alignment.center_world;
  offset.yaw_rad = std::atan2(alignment.motion.linear()(1, 0), alignment.motion.linear()(0, 0));
  const Eigen::Matrix4d covariance = information.inverse();
  offset.covariance = 0.5 * (covariance + covariance.transpose());  // Symmetric to the last bit.
  offset.anchors = static_cast<std::uint32_t>(alignment.agreeing);
  return offset;
}

/// True if much of the surface of `seen` is within the error of two looks at `known`, and the
/// correction brings no more there. Registration needs eight observed voxels around a point; thin
/// surface has few such points, which can be drawn off their place. This asks the nearest voxels.
bool FitsNoBetterMoved(const Registration& registration,
                       const TrackedObject& seen,
                       const TrackedObject& known,
                       const SessionIdentityParameters& parameters,
                       const VoxelScale& scale) {
  const Eigen::Isometry3d T_known_world = known.state().T_world_object.ToIsometry().inverse();
  const Eigen::Isometry3d T_world_seen = seen.state().T_world_object.ToIsometry();
  const auto close_share = [&](const Eigen::Isometry3d& T_correction) {
    return CompareSurfaces(seen,
                           known,
                           T_known_world * T_correction * T_world_seen,
                           parameters.parts.surface,
                           scale)
        .known_close_share();
  };
  const double at_rest = close_share(Eigen::Isometry3d::Identity());
  return at_rest >= parameters.parts.shares.substantial &&
         at_rest >= close_share(registration.T_correction);
}

}  // namespace

std::optional<Registration> RegisterToKnown(const TrackedObject& seen,
                                            const TrackedObject& known,
                                            const VoxelScale& scale) {
  if (!IsOfOneClass(seen, known)) return std::nullopt;
  const Box reach_world = Grow(seen.BoundsInWorld(), RegistrationParameters().search_distance_m);
  if (!reach_world.intersects(known.BoundsInWorld())) return std::nullopt;
  return RegisterPoints(seen.SurfaceInWorld(), known.volume(), scale, known.state().T_world_object);
}

double DisplacementOf(const Registration& registration, const TrackedObject& object) {
  return DisplacementOf(registration.shift_world, registration.yaw_rad, object);
}

double DisplacementOf(const Eigen::Isometry3d& motion, const TrackedObject& object) {
  const Eigen::Vector3d& center_world = object.cuboid().center_world;
  const double yaw_rad = std::atan2(motion.linear()(1, 0), motion.linear()(0, 0));
  const Eigen::Vector3d shift_world = motion * center_world - center_world;
  return std::hypot(DisplacementOf(shift_world, yaw_rad, object), shift_world.z());
}

bool FitsAtRest(const Registration& registration,
                const SessionIdentityParameters& parameters,
                const VoxelScale& scale) {
  // Near the surface, the loss is the square of the distance in inlier distances.
  const double inlier_m = RegistrationParameters().inlier_distance_voxels * scale.voxel_size_m;
  const double rest_m2 = registration.known_loss_at_rest * inlier_m * inlier_m;
  const double corrected_m2 = registration.known_loss * inlier_m * inlier_m;
  const double sigma_m = SurfaceSigmaM(parameters.parts.surface, scale);
  return registration.known_share_at_rest >= parameters.parts.shares.substantial &&
         rest_m2 - corrected_m2 <= std::max(sigma_m * sigma_m, corrected_m2);
}

bool IsDisplaced(const Registration& registration,
                 const TrackedObject& seen,
                 const TrackedObject& known,
                 const SessionIdentityParameters& parameters,
                 const VoxelScale& scale) {
  return DisplacementOf(registration, seen) > parameters.max_displacement_m &&
         !FitsAtRest(registration, parameters, scale) &&
         !FitsNoBetterMoved(registration, seen, known, parameters, scale);
}

std::optional<PoseOffset> AlignSession(const std::vector<const TrackedObject*>& seen,
                                       const std::vector<const TrackedObject*>& known,
                                       const SessionIdentityParameters& parameters,
                                       const VoxelScale& scale) {
  std::vector<AnchorMatches> anchors;
  std::vector<Eigen::Isometry3d> starts;
  for (const TrackedObject* object : seen) {
    for (const TrackedObject* other : known) {
      const std::optional<Registration> registration = RegisterToKnown(*object, *other, scale);
      if (!registration || registration->dissimilarity > parameters.parts.shares.negligible ||
          registration->known_share < parameters.parts.shares.majority ||
          DisplacementOf(*registration, *object) > parameters.max_session_offset_m) {
        continue;
      }
      anchors.push_back(MatchesOf(*object, *other, registration->T_correction, scale));
      starts.push_back(registration->T_correction);
    }
  }
  const double vote_scale_m = std::max(parameters.vote_scale_m, 0.5 * scale.voxel_size_m);
  const AlignmentPrior prior{Eigen::Isometry3d::Identity(), parameters.claim_votes};
  const AnchorAlignment alignment = AlignToAnchors(anchors, starts, vote_scale_m, prior);
  if (alignment.agreeing == 0) return std::nullopt;
  return OffsetOf(alignment, vote_scale_m, parameters.max_session_offset_m);
}

}  // namespace steadymap

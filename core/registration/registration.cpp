#include "core/registration/registration.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/registration/point_alignment.h"

namespace steadymap {
namespace {

// Spacing of the starts of the search. Descents from adjacent starts overlap: a descent requires
// points in the truncation band, of which trilinear sampling excludes one voxel.
constexpr double kStartSpacingTruncations = 0.7;
constexpr double kStartSpacingRad = 0.1;

// Maximum number of starts per side and direction. It bounds the time for any parameters.
constexpr int kMaxStartsASide = 4;

// Number of points and steps sufficient to rank the starts.
constexpr std::size_t kRankingPoints = 40;
constexpr std::size_t kTrialPoints = 120;
constexpr int kTrialIterations = 5;
constexpr std::size_t kTrials = 3;

// A share of outliers above this value after a trial shows that the points are not of this object.
// Further steps are then useless.
constexpr double kHopelessDissimilarity = 0.3;

/// Points beyond the range of valid poses are errors. Their exclusion keeps sums finite.
constexpr double kMaxPointM = 2.0 * kMaxPositionM;

/// Calls `visit` for at most `wanted` valid points: evenly spread over the span, in its order,
/// without a period that could alias with the rows of an image.
template <typename Visit>
void ForEachOfSample(std::span<const Eigen::Vector3d> points, std::size_t wanted, Visit visit) {
  const std::size_t size = std::min(wanted, points.size());
  const double stride = static_cast<double>(points.size()) / static_cast<double>(wanted);
  // The golden ratio as a fraction of 2^32: its multiples are evenly distributed within the
  // strides.
  constexpr std::uint32_t kGoldenRatio = 2654435769U;
  constexpr double kFractionUnit = 1.0 / 4294967296.0;
  std::uint32_t fraction = 0;
  for (std::size_t i = 0; i < size; ++i, fraction += kGoldenRatio) {
    const double jitter = static_cast<double>(fraction) * kFractionUnit;
    const std::size_t chosen =
        size == points.size()
            ? i
            : std::min(static_cast<std::size_t>((static_cast<double>(i) + jitter) * stride),
                       points.size() - 1);
    const Eigen::Vector3d& point = points[chosen];
    // NaN also fails the comparison; maxCoeff() could ignore it.
    if ((point.array().abs() <= kMaxPointM).all()) visit(point);
  }
}

/// The points to align as offsets from their centroid, object frame.
struct AlignmentPoints {
  std::vector<Eigen::Vector3d> offsets;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  double lever_m = 0.0;  ///< Root mean square distance from the vertical axis through the centroid.

  /// Returns at most `wanted` offsets, evenly selected.
  std::vector<Eigen::Vector3d> Part(std::size_t wanted) const {
    std::vector<Eigen::Vector3d> part;
    part.reserve(std::min(wanted, offsets.size()));
    ForEachOfSample(
        offsets, wanted, [&](const Eigen::Vector3d& offset) { part.push_back(offset); });
    return part;
  }
};

AlignmentPoints SampleAlignmentPoints(std::span<const Eigen::Vector3d> points_world,
                                      const Eigen::Isometry3d& T_object_world,
                                      std::size_t wanted) {
  AlignmentPoints points;
  points.offsets.reserve(std::min(wanted, points_world.size()));
  ForEachOfSample(points_world, wanted, [&](const Eigen::Vector3d& point_world) {
    points.offsets.emplace_back(T_object_world * point_world);
    points.centroid += points.offsets.back();
  });
  if (points.offsets.empty()) return points;
  const double count = static_cast<double>(points.offsets.size());
  points.centroid /= count;
  for (Eigen::Vector3d& offset : points.offsets) {
    offset -= points.centroid;
    points.lever_m += offset.head<2>().squaredNorm() / count;
  }
  points.lever_m = std::sqrt(points.lever_m);
  return points;
}

/// Returns evenly spaced values from `-range` to `range`, including 0, whose cells cover the range.
std::vector<double> StartsWithin(double range, double spacing) {
  const int a_side = static_cast<int>(
      std::clamp(std::ceil(range / spacing - 0.5), 0.0, static_cast<double>(kMaxStartsASide)));
  std::vector<double> starts;
  for (int i = -a_side; i <= a_side; ++i) {
    starts.push_back(range * 2.0 * i / (2.0 * a_side + 1.0));
  }
  return starts;
}

/// One registration: from the points to the selected motion.
class Search {
 public:
  Search(TsdfSampler* sampler,
         const AlignmentPoints& points,
         const RegistrationParameters& parameters)
      : sampler_(*sampler),
        points_(points),
        parameters_(parameters),
        alignment_(sampler,
                   points.centroid,
                   std::max(points.lever_m, sampler->scale().voxel_size_m),
                   parameters) {}

  AlignmentDescent Run() {
    AlignmentDescent best;
    best.fit = alignment_.Linearize(points_.offsets, {});
    best.converged = best.fit.known > 0;
    fit_at_rest_ = best.fit;
    const bool rests = IsConsistent(best.fit) && IsConverged(best.fit);
    if (rests && IsComplete(best.fit)) return best;

    const std::vector<Eigen::Vector3d> trial_offsets = points_.Part(kTrialPoints);
    if (!rests) {
      best = Try({}, trial_offsets);
      if (IsConsistent(best.fit) && IsComplete(best.fit)) return Finish(best);
    }
    bool moves = !rests;
    double cost_to_beat = best.fit.cost - parameters_.min_gain_share;
    for (const UprightMotion& start : PromisingStarts()) {
      const AlignmentDescent trial = Try(start, trial_offsets);
      if (trial.fit.cost >= cost_to_beat) continue;
      // A consistent alignment is never replaced by an inconsistent one.
      if (IsConsistent(best.fit) && !IsConsistent(trial.fit)) continue;
      best = trial;
      cost_to_beat = trial.fit.cost;
      moves = true;
      if (IsConsistent(best.fit) && IsComplete(best.fit)) break;
    }
    if (!moves) return best;
    return IsInconsistent(best.fit) ? best : Finish(best);
  }

  /// Returns the fit without a motion, after `Run`.
  const AlignmentFit& fit_at_rest() const { return fit_at_rest_; }

 private:
  /// True if most points have a known distance.
  bool IsComplete(const AlignmentFit& fit) const {
    return static_cast<double>(fit.known) >=
           parameters_.min_complete_share * static_cast<double>(points_.offsets.size());
  }

  /// True if almost no points contradict the volume.
  bool IsConsistent(const AlignmentFit& fit) const {
    const std::size_t unknown = points_.offsets.size() - fit.known;
    const std::size_t counted = parameters_.unknown_is_outlier ? unknown : 0;
    const double outliers = static_cast<double>(fit.outliers + counted);
    const double judged = static_cast<double>(fit.known + counted);
    return fit.known > 0 && outliers <= parameters_.max_consistent_dissimilarity * judged;
  }

  /// True if further steps cannot make the points consistent.
  static bool IsInconsistent(const AlignmentFit& fit) {
    return static_cast<double>(fit.outliers) >
           kHopelessDissimilarity * static_cast<double>(fit.known);
  }

  /// True if the next step is too short to be distinguished from noise.
  bool IsConverged(const AlignmentFit& fit) const {
    const UprightMotion step = alignment_.Advance({}, alignment_.Step(fit, /*damping=*/0.0));
    return step.shift_m.norm() <= parameters_.max_unmoved_shift_m &&
           std::abs(step.yaw_rad) <= parameters_.max_unmoved_yaw_rad;
  }

  /// Executes a short descent with few points. The fit of the result is that of all points; it is
  /// not converged for them.
  AlignmentDescent Try(const UprightMotion& start, std::span<const Eigen::Vector3d> trial_offsets) {
    AlignmentDescent trial = alignment_.Descend(trial_offsets, start, kTrialIterations);
    // The motion along undetermined directions is removed: it may lower the cost only because more
    // points become known.
    if (start != UprightMotion{}) {
      ++trial.iterations;
      trial.motion = alignment_.DeterminedPart(trial.fit, trial.motion);
    }
    trial.fit = alignment_.Linearize(points_.offsets, trial.motion);
    trial.converged = false;
    return trial;
  }

  AlignmentDescent Finish(const AlignmentDescent& trial) {
    AlignmentDescent end =
        alignment_.Descend(points_.offsets, trial.motion, parameters_.max_iterations);
    end.iterations += trial.iterations;
    return end;
  }

  /// Returns a lattice of starts around the identity, without the identity, ordered by yaw.
  std::vector<UprightMotion> Lattice() const {
    const std::vector<double> steps = StartsWithin(
        parameters_.search_distance_m, kStartSpacingTruncations * sampler_.scale().truncation_m);
    std::vector<Eigen::Vector3d> shifts;
    for (const double x : steps) {
      for (const double y : steps) {
        for (const double z : steps) shifts.emplace_back(x, y, z);
      }
    }
    std::vector<UprightMotion> starts;
    for (const double yaw_rad : StartsWithin(parameters_.search_yaw_rad, kStartSpacingRad)) {
      for (const Eigen::Vector3d& shift_m : shifts) {
        const UprightMotion start{shift_m, yaw_rad};
        if (shift_m.norm() > parameters_.search_distance_m || start == UprightMotion{}) continue;
        starts.push_back(start);
      }
    }
    return starts;
  }

  /// Returns the starts of the lattice with the lowest costs, in increasing order of cost.
  std::vector<UprightMotion> PromisingStarts() {
    const std::vector<UprightMotion> starts = Lattice();
    const std::vector<double> costs = CostsOf(starts);
    std::vector<std::size_t> order(starts.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const std::size_t kept = std::min(kTrials, order.size());
    std::partial_sort(order.begin(),
                      order.begin() + static_cast<std::ptrdiff_t>(kept),
                      order.end(),
                      [&](std::size_t a, std::size_t b) {
                        return costs[a] < costs[b] || (costs[a] == costs[b] && a < b);
                      });
    std::vector<UprightMotion> promising(kept);
    for (std::size_t i = 0; i < kept; ++i) promising[i] = starts[order[i]];
    return promising;
  }

  /// Returns the cost of each start, up to a constant factor. The outer loop runs over the points,
  /// since the starts move a point to neighbouring voxels.
  std::vector<double> CostsOf(const std::vector<UprightMotion>& starts) {
    std::vector<double> costs(starts.size(), 0.0);
    for (const Eigen::Vector3d& offset : points_.Part(kRankingPoints)) {
      double yaw_rad = 0.0;
      Eigen::Vector3d turned = offset;
      for (std::size_t i = 0; i < starts.size(); ++i) {
        if (starts[i].yaw_rad != yaw_rad) {
          yaw_rad = starts[i].yaw_rad;
          turned = YawRotation(yaw_rad) * offset;
        }
        double distance_m = 0.0;
        const bool known =
            sampler_.SampleDistance(points_.centroid + turned + starts[i].shift_m, &distance_m);
        costs[i] += known ? alignment_.Loss(distance_m) : 1.0;
      }
    }
    return costs;
  }

  TsdfSampler& sampler_;
  const AlignmentPoints& points_;
  const RegistrationParameters& parameters_;
  PointAlignment alignment_;
  AlignmentFit fit_at_rest_;
};

/// Counts inliers and outliers after alignment, on more points than were aligned.
void Judge(std::span<const Eigen::Vector3d> points_world,
           const Eigen::Isometry3d& T_object_corrected,
           const RegistrationParameters& parameters,
           TsdfSampler* sampler,
           Registration* registration) {
  const double inlier_distance_m =
      parameters.inlier_distance_voxels * sampler->scale().voxel_size_m;
  std::size_t total = 0;
  std::size_t known = 0;
  std::size_t inliers = 0;
  double square_sum_m2 = 0.0;
  ForEachOfSample(
      points_world, parameters.max_verdict_points, [&](const Eigen::Vector3d& point_world) {
        ++total;
        double distance_m = 0.0;
        if (!sampler->SampleDistance(T_object_corrected * point_world, &distance_m)) return;
        ++known;
        if (std::abs(distance_m) > inlier_distance_m) return;
        ++inliers;
        square_sum_m2 += distance_m * distance_m;
      });
  if (total == 0) return;
  registration->known_share = static_cast<double>(known) / static_cast<double>(total);
  const std::size_t judged = parameters.unknown_is_outlier ? total : known;
  if (judged > 0) {
    registration->dissimilarity =
        static_cast<double>(judged - inliers) / static_cast<double>(judged);
  }
  if (inliers > 0) {
    registration->inlier_rms_m = std::sqrt(square_sum_m2 / static_cast<double>(inliers));
  }
}

}  // namespace

Registration RegisterPoints(std::span<const Eigen::Vector3d> points_world,
                            const VoxelReader& volume,
                            const VoxelScale& scale,
                            const UprightPose& T_world_object,
                            const RegistrationParameters& parameters) {
  Registration registration;
  const Eigen::Isometry3d T_world_grid = T_world_object.ToIsometry();
  const Eigen::Isometry3d T_grid_world = T_world_grid.inverse();
  const AlignmentPoints points =
      SampleAlignmentPoints(points_world, T_grid_world, parameters.max_alignment_points);
  if (points.offsets.empty()) return registration;
  TsdfSampler sampler(volume, scale);

  Search search(&sampler, points, parameters);
  const AlignmentDescent end = search.Run();
  registration.iterations = end.iterations;
  registration.known_loss = end.fit.known_cost;
  registration.known_loss_at_rest = search.fit_at_rest().known_cost;
  registration.known_share_at_rest =
      static_cast<double>(search.fit_at_rest().known) / static_cast<double>(points.offsets.size());
  registration.converged = end.converged;
  if (end.motion != UprightMotion{}) {
    const Eigen::Vector3d centroid_world = T_world_grid * points.centroid;
    registration.shift_world = T_world_grid.linear() * end.motion.shift_m;
    registration.yaw_rad = end.motion.yaw_rad;
    registration.T_correction = Eigen::Translation3d(centroid_world + registration.shift_world) *
                                Eigen::AngleAxisd(end.motion.yaw_rad, Eigen::Vector3d::UnitZ()) *
                                Eigen::Translation3d(-centroid_world);
  }
  Judge(
      points_world, T_grid_world * registration.T_correction, parameters, &sampler, &registration);
  return registration;
}

}  // namespace steadymap

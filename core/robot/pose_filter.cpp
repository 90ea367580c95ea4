#include "core/robot/pose_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "core/geometry/geometry.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Standard deviations of the changes that the hypotheses assume, as shares of the parameters.
constexpr std::array<double, kPoseErrorHypotheses> kChangeScales = {1.0, 1.0 / 4.0, 1.0 / 16.0};

constexpr int kMaxPoseIterations = 8;

// Below these steps, metres and radians, the registration has converged.
constexpr double kConvergedShiftM = 2e-4;
constexpr double kConvergedTurnRad = 1e-4;

// A registration whose last step is longer, in standard deviations, has not converged.
constexpr double kMaxLastStep2 = 1.0;

// The standard deviation of a pose that defines the world frame, as a share of the prior one.
constexpr double kDefiningShare = 0.01;

// Beyond what an object covers in the image at the claimed pose, since that is wrong; samples.
constexpr int kViewMarginSamples = 8;

// Lower bound of the distance at which a turn of an object moves its samples, metres.
constexpr double kMinLeverM = 0.1;

/// Returns the square of the Mahalanobis distance that a pose error exceeds as rarely as a normal
/// error is greater than so many standard deviations: chi square in six degrees of freedom, in the
/// approximation of Wilson and Hilferty (1931).
double MaxDistance2(double sigmas) {
  constexpr double kFreedom = 6.0;
  constexpr double kVariance = 2.0 / (9.0 * kFreedom);
  const double root = 1.0 - kVariance + sigmas * std::sqrt(kVariance);
  return kFreedom * root * root * root;
}

/// What a frame tells of the pose error, linearised at one value of it: the information matrix, and
/// the gradient of half the sum of squared residuals.
struct PoseMeasurement {
  Matrix6 information = Matrix6::Zero();
  PoseErrorVector gradient = PoseErrorVector::Zero();
};

/// Returns the inverse of a positive definite matrix, symmetric to the last bit.
Matrix6 SymmetricInverse(const Eigen::LLT<Matrix6>& factor) {
  const Matrix6 inverse = factor.solve(Matrix6::Identity());
  return 0.5 * (inverse + inverse.transpose());
}

/// Returns the derivative of the distance of a sample at `ray_world` from the camera, along a
/// normal, by the pose error.
PoseErrorVector Jacobian(const Eigen::Vector3d& ray_world, const Eigen::Vector3d& normal_world) {
  PoseErrorVector jacobian;
  jacobian << normal_world, ray_world.cross(normal_world);
  return jacobian;
}

/// What the samples on the surface of one object, or of the background, tell of the pose error. If
/// the object was moved since its surface was mapped, they ask for its displacement instead.
/// `place_sigma_m`: standard deviation of the place of an object that nobody moved.
class SurfaceVote {
 public:
  /// Adds a sample at `ray_world` from the camera and `distance_m` from the surface.
  void Add(const PoseErrorVector& jacobian,
           const Eigen::Vector3d& ray_world,
           double weight,
           double distance_m) {
    measurement_.information += weight * jacobian * jacobian.transpose();
    measurement_.gradient += weight * distance_m * jacobian;
    weight_ += weight;
    moment_m_ += weight * ray_world;
    square_moment_m2_ += weight * ray_world.squaredNorm();
  }

  /// Returns what the samples tell if their surface is where it was mapped.
  const PoseMeasurement& measurement() const { return measurement_; }

  /// Returns the robust weight of Cauchy, by the displacement that the samples ask for.
  /// `covariance`: of the pose error.
  double RobustWeight(double place_sigma_m, const Matrix6& covariance) const {
    if (!(weight_ > 0.0)) return 0.0;
    const Eigen::LLT<Matrix6> explained(PlaceCovariance(place_sigma_m) + covariance);
    const Matrix6 prior = SymmetricInverse(explained);
    const Eigen::LLT<Matrix6> posterior(prior + measurement_.information);
    const PoseErrorVector displacement = posterior.solve(measurement_.gradient);
    return 1.0 / (1.0 + displacement.dot(prior * displacement));
  }

 private:
  /// Returns the covariance of the place of an unmoved object, in the coordinates of a pose error:
  /// of its shift, and of a turn about its centroid that moves its samples as much.
  Matrix6 PlaceCovariance(double place_sigma_m) const {
    const Eigen::Vector3d center_m = moment_m_ / weight_;
    const double lever_m2 =
        std::max(square_moment_m2_ / weight_ - center_m.squaredNorm(), kMinLeverM * kMinLeverM);
    Matrix6 own = Matrix6::Zero();
    own.diagonal().head<3>().setConstant(place_sigma_m * place_sigma_m);
    own.diagonal().tail<3>().setConstant(place_sigma_m * place_sigma_m / lever_m2);
    Matrix6 to_camera = Matrix6::Identity();
    for (int axis = 0; axis < 3; ++axis) {
      to_camera.block<3, 1>(0, 3 + axis) = center_m.cross(Eigen::Vector3d::Unit(axis));
    }
    return to_camera * own * to_camera.transpose();
  }

  PoseMeasurement measurement_;
  double weight_ = 0.0;
  Eigen::Vector3d moment_m_ = Eigen::Vector3d::Zero();
  double square_moment_m2_ = 0.0;
};

/// The distance of a sample from the nearest surface that faces alike.
struct SurfaceHit {
  double distance_m = 0.0;
  Eigen::Vector3d normal_world = Eigen::Vector3d::Zero();
  bool is_of_session = false;  ///< Only the current session has seen it.
  std::size_t surface = 0;     ///< 0: the background, else that of an object in view.

  bool is_none() const { return normal_world.isZero(); }
};

/// The samples of one frame, and the surfaces of the map that they may be on.
class FrameRegistration {
 public:
  FrameRegistration(const PoseFilterParameters& parameters,
                    const FrameInMap& frame,
                    const WorkingMap& map)
      : parameters_(parameters),
        frame_(frame),
        scale_(map.scale()),
        camera_world_(frame.cloud.T_world_camera().translation()),
        background_(map.background(), map.scale()) {
    for (const ObjectInView& view : frame.in_view) {
      const bool is_of_session = view.object->state().status == ObjectStatus::kTentative;
      is_known_place_ = is_known_place_ || !is_of_session;
      surfaces_.push_back({view,
                           is_of_session,
                           view.object->state().T_world_object.ToIsometry().inverse(),
                           view.object->bounds_object(),
                           TsdfSampler(view.object->volume(), scale_)});
    }
    ChooseSamples();
  }

  /// Measures at a pose error. `covariance`: of that error.
  PoseMeasurement Measure(const PoseErrorVector& error, const Matrix6& covariance);

 private:
  struct Surface {
    ObjectInView view;
    bool is_of_session;
    Eigen::Isometry3d T_object_world;
    Box bounds_object;
    TsdfSampler sampler;
  };

  /// A sample at some pose error.
  struct MovedSample {
    SamplePlace place;
    Eigen::Vector3d point_world;
    Eigen::Vector3d normal_world;
    double reach_m;  ///< Its surface may be so far away along the normal.
  };

  void ChooseSamples();
  SurfaceHit FindSurface(const MovedSample& sample);

  const PoseFilterParameters& parameters_;
  const FrameInMap& frame_;
  const VoxelScale& scale_;
  Eigen::Vector3d camera_world_;  ///< At the claimed pose.
  TsdfSampler background_;
  std::vector<Surface> surfaces_;
  bool is_known_place_ = false;  ///< An earlier session has seen it, and so the background.
  std::vector<SamplePlace> places_;
};

void FrameRegistration::ChooseSamples() {
  const SampleGrid& samples = frame_.samples;
  const double share =
      static_cast<double>(samples.size()) / static_cast<double>(parameters_.min_samples);
  const int stride = std::max(1, static_cast<int>(std::sqrt(share)));
  for (int row = stride / 2; row < samples.height(); row += stride) {
    for (int column = stride / 2; column < samples.width(); column += stride) {
      if (samples.At(column, row).is_valid()) places_.push_back({column, row});
    }
  }
}

SurfaceHit FrameRegistration::FindSurface(const MovedSample& sample) {
  SurfaceHit nearest{.distance_m = std::max(sample.reach_m, scale_.truncation_m)};
  const auto take = [&](TsdfSampler* sampler,
                        const Eigen::Isometry3d& T_volume_world,
                        bool is_of_session,
                        std::size_t surface) {
    // Distances are known only near the surface, so a sample far from it searches along its normal.
    for (int i = 0;; ++i) {
      const int step = (i + 1) / 2;
      const double shift_m = (i % 2 == 0 ? -step : step) * scale_.truncation_m;
      if (std::abs(shift_m) >= std::abs(nearest.distance_m)) break;
      const Eigen::Vector3d point_world = sample.point_world - shift_m * sample.normal_world;
      const DistanceSample found = sampler->Sample(T_volume_world * point_world);
      const bool is_measured = found.known && found.weight > static_cast<double>(kWeightUnit);
      if (!is_measured || found.slope > kMaxSurfaceSlope) continue;
      const Eigen::Vector3d normal_world = T_volume_world.linear().transpose() * found.gradient;
      const double cosine = normal_world.dot(sample.normal_world);
      const double distance_m = found.distance_m + shift_m * cosine;
      if (cosine < parameters_.min_normal_cosine) continue;
      if (std::abs(distance_m) >= std::abs(nearest.distance_m)) continue;
      nearest = {distance_m, normal_world, is_of_session, surface};
    }
  };
  take(&background_, Eigen::Isometry3d::Identity(), !is_known_place_, 0);
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    Surface& surface = surfaces_[i];
    const ObjectInView& view = surface.view;
    if (sample.place.column < view.first_column - kViewMarginSamples ||
        sample.place.column >= view.end_column + kViewMarginSamples ||
        sample.place.row < view.first_row - kViewMarginSamples ||
        sample.place.row >= view.end_row + kViewMarginSamples) {
      continue;
    }
    const Eigen::Vector3d point_object = surface.T_object_world * sample.point_world;
    if (!Grow(surface.bounds_object, std::abs(nearest.distance_m)).contains(point_object)) continue;
    take(&surface.sampler, surface.T_object_world, surface.is_of_session, i + 1);
  }
  return nearest;
}

PoseMeasurement FrameRegistration::Measure(const PoseErrorVector& error,
                                           const Matrix6& covariance) {
  const Eigen::Matrix3d turn = TransformOf(Eigen::Vector3d::Zero(), error.tail<3>()).linear();
  const double surface_sigma_m = parameters_.surface_sigma_voxels * scale_.voxel_size_m;
  const double gate = parameters_.max_sigmas * parameters_.max_sigmas;
  std::vector<SurfaceVote> votes(surfaces_.size() + 1);
  for (const SamplePlace& place : places_) {
    const SurfaceSample& sample = frame_.samples.At(place.column, place.row);
    const Eigen::Vector3d ray_world = turn * (sample.position_world.cast<double>() - camera_world_);
    const Eigen::Vector3d point_world = camera_world_ + error.head<3>() + ray_world;
    const Eigen::Vector3d normal_world = turn * sample.normal_world.cast<double>();
    const PoseErrorVector along_normal = Jacobian(ray_world, normal_world);
    const double reach_m =
        parameters_.max_sigmas * std::sqrt(along_normal.dot(covariance * along_normal));
    const SurfaceHit hit = FindSurface({place, point_world, normal_world, reach_m});
    if (hit.is_none()) continue;
    const PoseErrorVector jacobian = Jacobian(ray_world, hit.normal_world);
    const double depth_m = static_cast<double>(sample.depth_m);
    // The noise is along the ray; on a surface at a flat angle it moves a sample little off it.
    const double noise_m =
        frame_.cloud.depth_noise().SigmaM(depth_m) * ray_world.dot(hit.normal_world) / depth_m;
    const double variance_m2 = noise_m * noise_m + surface_sigma_m * surface_sigma_m;
    // The robust weight of Geman and McClure, at the scale of what the pose error explains.
    const double explained_m2 = variance_m2 + jacobian.dot(covariance * jacobian);
    const double excess = 1.0 + hit.distance_m * hit.distance_m / (gate * explained_m2);
    const double share = hit.is_of_session ? parameters_.session_share : 1.0;
    const double weight = share / (variance_m2 * excess * excess);
    votes[hit.surface].Add(jacobian, ray_world, weight, hit.distance_m);
  }
  PoseMeasurement measurement;
  for (const SurfaceVote& vote : votes) {
    const double weight = vote.RobustWeight(parameters_.place_sigma_m, covariance);
    measurement.information += weight * vote.measurement().information;
    measurement.gradient += weight * vote.measurement().gradient;
  }
  return measurement;
}

double LogDeterminant(const Eigen::LLT<Matrix6>& factor) {
  double sum = 0.0;
  for (int i = 0; i < 6; ++i) sum += std::log(factor.matrixLLT()(i, i));
  return 2.0 * sum;
}

/// Updates a hypothesis by a measurement at `error`. Returns its log likelihood, up to a constant
/// that all hypotheses have in common.
double UpdateHypothesis(const PoseErrorVector& error,
                        const PoseMeasurement& measurement,
                        PoseError* hypothesis) {
  const Eigen::LLT<Matrix6> covariance_before(hypothesis->covariance);
  const Matrix6 before = SymmetricInverse(covariance_before);
  const PoseErrorVector offset = hypothesis->mean - error;
  const PoseErrorVector pull = before * offset - measurement.gradient;
  const Eigen::LLT<Matrix6> after(before + measurement.information);
  const PoseErrorVector step = after.solve(pull);
  hypothesis->mean = error + step;
  hypothesis->covariance = SymmetricInverse(after);
  return 0.5 * (pull.dot(step) - offset.dot(before * offset) - LogDeterminant(covariance_before) -
                LogDeterminant(after));
}

void UpdateHypotheses(const PoseErrorVector& error,
                      const PoseMeasurement& measurement,
                      PoseErrorEstimate* estimate) {
  std::array<double, kPoseErrorHypotheses> likelihoods;
  for (std::size_t i = 0; i < likelihoods.size(); ++i) {
    likelihoods[i] = UpdateHypothesis(error, measurement, &estimate->hypotheses[i].error);
  }
  const double best = *std::max_element(likelihoods.begin(), likelihoods.end());
  double sum = 0.0;
  for (std::size_t i = 0; i < likelihoods.size(); ++i) {
    estimate->hypotheses[i].probability *= std::exp(likelihoods[i] - best);
    sum += estimate->hypotheses[i].probability;
  }
  for (PoseErrorHypothesis& hypothesis : estimate->hypotheses) hypothesis.probability /= sum;
}

}  // namespace

/// Returns the covariance of the error of a claimed pose.
Matrix6 PoseFilter::Prior() const {
  Matrix6 prior = Matrix6::Zero();
  prior.diagonal().head<3>().setConstant(parameters_.sigma_m * parameters_.sigma_m);
  prior.diagonal().tail<3>().setConstant(parameters_.sigma_rad * parameters_.sigma_rad);
  return prior;
}

PoseErrorEstimate PoseFilter::Predict(const std::optional<PoseErrorEstimate>& last,
                                      Timestamp time) const {
  const Matrix6 prior = Prior();
  PoseErrorEstimate estimate;
  estimate.time = time;
  constexpr double kUniform = 1.0 / kPoseErrorHypotheses;
  if (!last) {
    estimate.hypotheses.fill({{PoseErrorVector::Zero(), prior}, kUniform});
    return estimate;
  }
  const double elapsed_s = std::abs((time - last->time).seconds());
  const double kept = std::exp(-elapsed_s / parameters_.correlation_s);
  estimate.hypotheses = last->hypotheses;
  for (std::size_t i = 0; i < kChangeScales.size(); ++i) {
    PoseErrorHypothesis& hypothesis = estimate.hypotheses[i];
    const double changed = (1.0 - kept * kept) * kChangeScales[i] * kChangeScales[i];
    hypothesis.error.mean *= kept;
    hypothesis.error.covariance = kept * kept * hypothesis.error.covariance + changed * prior;
    hypothesis.probability = kept * hypothesis.probability + (1.0 - kept) * kUniform;
  }
  return estimate;
}

PoseErrorEstimate PoseFilter::Update(const std::optional<PoseErrorEstimate>& last,
                                     Timestamp time,
                                     const FrameInMap& frame,
                                     const WorkingMap& map) const {
  PoseErrorEstimate estimate = Predict(last, time);
  if (map.background().leaf_count() == 0 && map.objects().empty()) {
    for (PoseErrorHypothesis& hypothesis : estimate.hypotheses) {
      hypothesis.error.covariance *= kDefiningShare * kDefiningShare;
    }
    return estimate;
  }
  const double elapsed_s = last ? std::abs((time - last->time).seconds()) : parameters_.look_s;
  const double new_share = std::min(1.0, elapsed_s / parameters_.look_s);
  FrameRegistration registration(parameters_, frame, map);
  const PoseError predicted = estimate.Combined();
  const Matrix6 prior_information = SymmetricInverse(Eigen::LLT<Matrix6>(predicted.covariance));
  PoseErrorVector error = predicted.mean;
  Matrix6 covariance = predicted.covariance;
  PoseMeasurement measurement;
  double last_step2 = 0.0;  // Square of its Mahalanobis distance.
  for (int i = 0; i < kMaxPoseIterations; ++i) {
    measurement = registration.Measure(error, covariance);
    measurement.information *= new_share;
    measurement.gradient *= new_share;
    const Eigen::LLT<Matrix6> information(prior_information + measurement.information);
    const PoseErrorVector gradient =
        prior_information * (error - predicted.mean) + measurement.gradient;
    const PoseErrorVector step = information.solve(gradient);
    covariance = SymmetricInverse(information);
    last_step2 = step.dot(gradient);
    if (step.head<3>().norm() < kConvergedShiftM && step.tail<3>().norm() < kConvergedTurnRad) {
      break;
    }
    error -= step;
  }
  if (last_step2 > kMaxLastStep2) return estimate;
  PoseErrorEstimate updated = estimate;
  UpdateHypotheses(error, measurement, &updated);
  const PoseErrorVector mean = updated.Combined().mean;
  // Both the claimed pose is off and the one that defined the world frame.
  const Eigen::Matrix<double, 6, 1> variances = 2.0 * Prior().diagonal();
  const double distance2 = mean.dot(mean.cwiseQuotient(variances));
  return distance2 > MaxDistance2(parameters_.max_sigmas) ? estimate : updated;
}

}  // namespace steadymap

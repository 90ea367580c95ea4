#include "core/registration/registration.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/mapper.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"

namespace steadymap {
namespace {

using ::steadymap::testing::AnalyticCamera;
using ::steadymap::testing::Crate;
using ::steadymap::testing::DistanceFrom;
using ::steadymap::testing::kScale;
using ::steadymap::testing::LookAt;
using ::steadymap::testing::LookAtSurface;
using ::steadymap::testing::LooksAround;
using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::RandomMotionAbout;
using ::steadymap::testing::RandomShift;
using ::steadymap::testing::RangeTo;
using ::steadymap::testing::RenderAnalytic;
using ::steadymap::testing::Solid;
using ::steadymap::testing::Sphere;
using ::steadymap::testing::SurfaceView;
using ::steadymap::testing::ThingsToLookAt;
using ::steadymap::testing::UprightMotionAbout;
using ::steadymap::testing::WithNoise;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMaxYawRad = 8.0 * kDegree;
constexpr double kRecoveredM = 0.01;
constexpr double kRecoveredRad = 0.5 * kDegree;

/// Yields about 1 000 points on each test object.
constexpr double kSpacingRad = 0.016;

Eigen::Vector3d MeanOf(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

/// The error of a correction, relative to the inverse of the motion.
struct Miss {
  double shift_m = 0.0;
  double yaw_rad = 0.0;

  bool recovered() const { return shift_m <= kRecoveredM && yaw_rad <= kRecoveredRad; }
};

/// Moves the points of a view by a random motion and registers them.
class MotionTrial {
 public:
  explicit MotionTrial(std::uint64_t seed) : random_(seed) {}

  Miss Run(const SurfaceView& view, const VoxelReader& volume, const UprightPose& T_world_object) {
    std::uniform_real_distribution<double> noise_m(0.002, 0.005);
    std::vector<Eigen::Vector3d> points = WithNoise(view, noise_m(random_), &random_);
    const Eigen::Isometry3d T_world_grid = T_world_object.ToIsometry();
    for (Eigen::Vector3d& point : points) point = T_world_grid * point;
    const Eigen::Vector3d center = MeanOf(points);
    const Eigen::Isometry3d T_moved_world = RandomMotionAbout(center, &random_);
    for (Eigen::Vector3d& point : points) point = T_moved_world * point;
    registration_ = RegisterPoints(points, volume, kScale, T_world_object);
    const Eigen::Isometry3d T_rest = registration_.T_correction * T_moved_world;
    return {(T_rest * center - center).norm(), std::abs(YawOf(T_rest))};
  }

  const Registration& registration() const { return registration_; }

 private:
  std::mt19937_64 random_;
  Registration registration_;
};

/// The objects to register, their volumes and views of them.
struct Gallery {
  std::vector<Solid> solids = ThingsToLookAt();
  std::vector<TsdfGrid> volumes;
  std::vector<std::vector<SurfaceView>> views;

  Gallery() {
    for (const Solid& solid : solids) {
      volumes.push_back(MakeVolume(solid, kScale));
      views.push_back(LooksAround(solid, kSpacingRad));
    }
  }
};

TEST(RegisterPoints, RecoversKnownMotions) {
  constexpr int kMotions = 5000;
  const Gallery gallery;
  const UprightPose T_world_object{{12.3, -7.1, 0.4}, 0.7};
  MotionTrial trial(1);
  int recovered = 0;
  for (int i = 0; i < kMotions; ++i) {
    const std::size_t which = static_cast<std::size_t>(i) % gallery.solids.size();
    const std::vector<SurfaceView>& views = gallery.views[which];
    const SurfaceView& view = views[static_cast<std::size_t>(i) / 3 % views.size()];
    if (trial.Run(view, gallery.volumes[which], T_world_object).recovered()) ++recovered;
    const Registration& registration = trial.registration();
    ASSERT_TRUE(registration.T_correction.matrix().allFinite());
    ASSERT_TRUE(registration.iterations > 0 || registration.shift_world.isZero(0.0));
    ASSERT_NEAR(registration.yaw_rad, YawOf(registration.T_correction), 1e-9);
  }
  EXPECT_GE(recovered, kMotions * 99 / 100);
  RecordProperty("recovered", recovered);
}

TEST(RegisterPoints, RecoversMotionsAgainstAFusedVolumeFromAnotherSide) {
  constexpr int kMotions = 600;
  const Gallery gallery;
  int recovered = 0;
  for (std::size_t which = 0; which < gallery.solids.size(); ++which) {
    const std::unique_ptr<Mapper> mapper = Mapper::Create(MapConfig()).value();
    for (const double azimuth_deg : {-20.0, 10.0, 45.0, 80.0, 110.0}) {
      const double azimuth = azimuth_deg * kDegree;
      const Eigen::Vector3d eye(2.0 * std::cos(azimuth), 2.0 * std::sin(azimuth), 1.7);
      mapper->Integrate(
          mapper->head().Next(),
          RenderAnalytic(
              RangeTo(gallery.solids[which]), AnalyticCamera(), LookAt(eye, {0.0, 0.0, 0.4})));
    }
    const std::shared_ptr<const MapSnapshot> snapshot = mapper->Commit().snapshot;
    // The views of the first quadrant observe the mapped side.
    const std::vector<SurfaceView>& views = gallery.views[which];
    MotionTrial trial(2 + which);
    for (int i = 0; i < kMotions / 3; ++i) {
      const SurfaceView& view = views[static_cast<std::size_t>(i) % (views.size() / 4)];
      const Miss miss = trial.Run(view, snapshot->background, UprightPose());
      if (miss.recovered()) ++recovered;
    }
  }
  // In some views of the crate, only a narrow strip of one side constrains the shift.
  EXPECT_GE(recovered, kMotions * 97 / 100);
  RecordProperty("recovered", recovered);
}

TEST(RegisterPoints, LeavesWhatFitsWhereItIs) {
  const Gallery gallery;
  std::mt19937_64 random(3);
  const UprightPose T_world_object{{-3.0, 8.0, 0.0}, -1.2};
  for (std::size_t which = 0; which < gallery.solids.size(); ++which) {
    for (const SurfaceView& view : gallery.views[which]) {
      std::vector<Eigen::Vector3d> points = WithNoise(view, 0.005, &random);
      for (Eigen::Vector3d& point : points) point = T_world_object.ToIsometry() * point;
      const Registration registration =
          RegisterPoints(points, gallery.volumes[which], kScale, T_world_object);
      EXPECT_EQ(registration.iterations, 0);
      EXPECT_TRUE(registration.converged);
      EXPECT_EQ(registration.T_correction.matrix(), Eigen::Matrix4d::Identity());
      EXPECT_EQ(registration.shift_world, Eigen::Vector3d::Zero());
      EXPECT_LT(registration.dissimilarity, 0.01);
      EXPECT_GT(registration.known_share, 0.95);
      EXPECT_LT(registration.inlier_rms_m, 0.006);
    }
  }
}

/// Returns points of a wall along x from `left_m` to `right_m`, 2 m high, 0.2 m in front of the xz
/// plane.
std::vector<Eigen::Vector3d> WallPoints(double left_m, double right_m, std::mt19937_64* random) {
  std::uniform_real_distribution<double> x(left_m, right_m);
  std::uniform_real_distribution<double> z(0.2, 1.8);
  std::normal_distribution<double> noise(0.2, 0.003);
  std::vector<Eigen::Vector3d> points(2000);
  for (Eigen::Vector3d& point : points) point = {x(*random), noise(*random), z(*random)};
  return points;
}

TsdfGrid LongWall(double left_m, double right_m) {
  return MakeVolume(
      [](const Eigen::Vector3d& point) { return point.y() - 0.2; },
      Box(Eigen::Vector3d(left_m, 0.0, 0.0), Eigen::Vector3d(right_m, 0.4, 2.0)),
      kScale,
      [&](const Eigen::Vector3d& point) { return point.x() >= left_m && point.x() <= right_m; });
}

TEST(RegisterPoints, TellsHowPointsFitWithoutTheCorrection) {
  const Solid crate = Crate();
  const TsdfGrid volume = MakeVolume(crate, kScale);
  std::mt19937_64 random(5);
  std::vector<Eigen::Vector3d> points;
  for (const SurfaceView& view : LooksAround(crate, kSpacingRad)) {
    for (const Eigen::Vector3d& point : WithNoise(view, 0.003, &random)) points.push_back(point);
  }
  const Registration rest = RegisterPoints(points, volume, kScale, {});
  EXPECT_LT(rest.known_loss_at_rest, 0.05);
  EXPECT_DOUBLE_EQ(rest.known_loss, rest.known_loss_at_rest);
  EXPECT_GT(rest.known_share_at_rest, 0.9);
  for (Eigen::Vector3d& point : points) point.x() += 0.08;
  const Registration moved = RegisterPoints(points, volume, kScale, {});
  EXPECT_LT(moved.known_loss, 0.05);
  EXPECT_GT(moved.known_loss_at_rest, moved.known_loss + 0.1);
}

TEST(RegisterPoints, DoesNotSlideAlongAWall) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> yaw(-kMaxYawRad, kMaxYawRad);
  const TsdfGrid volume = LongWall(-2.0, 2.0);
  for (int i = 0; i < 200; ++i) {
    // The left end moves from well within the wall to halfway beyond the mapped end.
    const double left_m = 0.01 * i - 0.5;
    std::vector<Eigen::Vector3d> points = WallPoints(left_m, left_m + 1.5, &random);
    const Eigen::Vector3d center = MeanOf(points);
    const Eigen::Vector3d shift_m(0.0, RandomShift(0.1, &random).x(), 0.0);
    const Eigen::Isometry3d motion = UprightMotionAbout(center, shift_m, yaw(random));
    for (Eigen::Vector3d& point : points) point = motion * point;
    const Registration registration = RegisterPoints(points, volume, kScale, UprightPose());
    const Eigen::Vector3d rest = registration.T_correction * (center + shift_m) - center;
    EXPECT_LT(std::abs(rest.x()), 0.01) << i << ": " << registration.shift_world.transpose();
    EXPECT_LT(std::abs(rest.z()), 0.002) << i;
    EXPECT_LT(std::abs(rest.y()), 0.03) << i;
    EXPECT_LT(registration.dissimilarity, 0.02) << i;
  }
}

TEST(RegisterPoints, SurfaceNotMappedYetIsNoOutlierUnlessAskedFor) {
  std::mt19937_64 random(5);
  const TsdfGrid volume = LongWall(-2.0, 0.0);
  const std::vector<Eigen::Vector3d> points = WallPoints(-1.0, 1.0, &random);
  RegistrationParameters parameters;
  const Registration ours = RegisterPoints(points, volume, kScale, UprightPose(), parameters);
  EXPECT_EQ(ours.iterations, 0);
  EXPECT_EQ(ours.T_correction.matrix(), Eigen::Matrix4d::Identity());
  EXPECT_EQ(ours.dissimilarity, 0.0);
  EXPECT_NEAR(ours.known_share, 0.5, 0.05);
  parameters.unknown_is_outlier = true;
  const Registration papers = RegisterPoints(points, volume, kScale, UprightPose(), parameters);
  EXPECT_NEAR(papers.dissimilarity, 0.5, 0.05);
}

TEST(RegisterPoints, AnObjectThatGrowsStaysInPlace) {
  const Gallery gallery;
  std::mt19937_64 random(6);
  for (std::size_t which = 0; which < gallery.solids.size(); ++which) {
    // The map ends at a border that cuts the object. In most views, as much surface is visible
    // beyond the border.
    for (const double border_m : {-0.15, 0.0, 0.15}) {
      const TsdfGrid volume = MakeVolume(
          [&](const Eigen::Vector3d& point) { return DistanceFrom(gallery.solids[which], point); },
          Box(Eigen::Vector3d(-0.7, -0.7, 0.0), Eigen::Vector3d(0.7, 0.7, 1.2)),
          kScale,
          [&](const Eigen::Vector3d& point) { return point.y() <= border_m; });
      for (const SurfaceView& view : gallery.views[which]) {
        const Registration registration =
            RegisterPoints(WithNoise(view, 0.003, &random), volume, kScale, UprightPose());
        EXPECT_LT(registration.shift_world.norm(), 0.01)
            << which << " " << border_m << " known " << registration.known_share;
        EXPECT_LT(registration.dissimilarity, 0.02);
      }
    }
  }
}

TEST(RegisterPoints, AnotherShapeIsDissimilar) {
  const Gallery gallery;
  std::mt19937_64 random(7);
  constexpr double kDissimilarityMax = 0.1;
  RegistrationParameters as_in_the_paper;
  as_in_the_paper.unknown_is_outlier = true;
  int looks = 0;
  int dissimilar = 0;
  for (std::size_t seen = 0; seen < gallery.solids.size(); ++seen) {
    for (std::size_t mapped = 0; mapped < gallery.solids.size(); ++mapped) {
      if (seen == mapped) continue;
      const TsdfGrid& volume = gallery.volumes[mapped];
      for (const SurfaceView& view : gallery.views[seen]) {
        const std::vector<Eigen::Vector3d> points = WithNoise(view, 0.003, &random);
        const Registration ours = RegisterPoints(points, volume, kScale, UprightPose());
        const Registration papers =
            RegisterPoints(points, volume, kScale, UprightPose(), as_in_the_paper);
        EXPECT_GT(papers.dissimilarity, kDissimilarityMax) << seen << " as " << mapped;
        if (ours.dissimilarity > kDissimilarityMax) ++dissimilar;
        ++looks;
      }
    }
  }
  // From some sides, the angle and the crate with its parcel differ only in unobserved surface.
  EXPECT_GE(dissimilar, looks * 3 / 4);
  RecordProperty("dissimilar_percent", 100 * dissimilar / looks);
}

TEST(RegisterPoints, ABallIsNoCrate) {
  const TsdfGrid volume = MakeVolume(Crate(), kScale);
  const SurfaceView view =
      LookAtSurface(Sphere({0.0, 0.0, 0.5}, 0.5), {1.5, 1.0, 1.5}, {0.0, 0.0, 0.5}, kSpacingRad);
  ASSERT_GT(view.points.size(), 500U);
  EXPECT_GT(RegisterPoints(view.points, volume, kScale, UprightPose()).dissimilarity, 0.3);
}

TEST(RegisterPoints, NothingToGoByGivesTheIdentityAndNoSimilarity) {
  const TsdfGrid volume = MakeVolume(Crate(), kScale);
  const TsdfGrid empty;
  const std::vector<Eigen::Vector3d> points(100, {0.25, 0.1, 0.5});
  const std::vector<Eigen::Vector3d> far_points(100, {30.0, 0.1, 0.5});
  const std::vector<Eigen::Vector3d> wild_points = {
      {std::nan(""), 0.0, 0.0}, {0.0, HUGE_VAL, 0.0}, {0.0, 0.0, -1e300}};
  const auto expect_nothing = [](const Registration& registration) {
    EXPECT_EQ(registration.T_correction.matrix(), Eigen::Matrix4d::Identity());
    EXPECT_EQ(registration.dissimilarity, 1.0);
    EXPECT_EQ(registration.known_share, 0.0);
    EXPECT_EQ(registration.inlier_rms_m, 0.0);
    EXPECT_EQ(registration.iterations, 0);
    EXPECT_FALSE(registration.converged);
  };
  expect_nothing(RegisterPoints({}, volume, kScale, UprightPose()));
  expect_nothing(RegisterPoints(points, empty, kScale, UprightPose()));
  expect_nothing(RegisterPoints(far_points, volume, kScale, UprightPose()));
  expect_nothing(RegisterPoints(wild_points, volume, kScale, UprightPose()));
}

TEST(RegisterPoints, LeavesOutPointsThatAreNotFinite) {
  const Gallery gallery;
  const TsdfGrid& volume = gallery.volumes[0];
  std::vector<Eigen::Vector3d> points = gallery.views[0][0].points;
  for (std::size_t i = 0; i < points.size(); i += 7) points[i].y() = std::nan("");
  for (std::size_t i = 0; i < points.size(); i += 11) points[i].z() = 1e200;
  for (Eigen::Vector3d& point : points) point.x() += 0.05;
  const Registration registration = RegisterPoints(points, volume, kScale, UprightPose());
  EXPECT_NEAR(registration.shift_world.x(), -0.05, kRecoveredM);
  EXPECT_LT(registration.dissimilarity, 0.01);
}

TEST(RegisterPoints, TakesOnePointAndManyTimesTheSame) {
  const TsdfGrid volume = MakeVolume(Crate(), kScale);
  for (const std::size_t count : {1U, 2U, 5000U}) {
    const std::vector<Eigen::Vector3d> points(count, {0.3, 0.1, 0.5});
    const Registration registration = RegisterPoints(points, volume, kScale, UprightPose());
    EXPECT_NEAR(registration.shift_world.x(), -0.05, 0.01);
    EXPECT_NEAR(registration.shift_world.tail<2>().norm(), 0.0, 0.01);
    EXPECT_NEAR(registration.yaw_rad, 0.0, 1e-9);
    EXPECT_EQ(registration.dissimilarity, 0.0);
  }
}

TEST(RegisterPoints, GoesNoFurtherThanItMaySearch) {
  const Gallery gallery;
  RegistrationParameters parameters;
  parameters.search_distance_m = 0.0;
  parameters.search_yaw_rad = 0.0;
  std::vector<Eigen::Vector3d> points = gallery.views[0][0].points;
  for (Eigen::Vector3d& point : points) point += Eigen::Vector3d(0.04, -0.03, 0.02);
  const Registration near =
      RegisterPoints(points, gallery.volumes[0], kScale, UprightPose(), parameters);
  EXPECT_LT((near.shift_world - Eigen::Vector3d(-0.04, 0.03, -0.02)).norm(), kRecoveredM);
  for (Eigen::Vector3d& point : points) point.x() += 0.5;
  const Registration far =
      RegisterPoints(points, gallery.volumes[0], kScale, UprightPose(), parameters);
  EXPECT_LE(far.shift_world.norm(), kScale.truncation_m);
  EXPECT_GT(far.dissimilarity, 0.1);
}

}  // namespace
}  // namespace steadymap

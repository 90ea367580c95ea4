// Registers frames of a room to a map of it, with known errors of their poses.

#include "core/robot/pose_filter.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "core/geometry/geometry.h"
#include "tests/core/policy/map_story.h"
#include "tests/core/policy/room_drive.h"
#include "tests/support/analytic_depth.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Drive;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::FinePocdConfig;
using ::steadymap::testing::Goods;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::LookAtScene;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::PocdConfig;
using ::steadymap::testing::Room;
using ::steadymap::testing::RoomWithout;
using ::steadymap::testing::Scene;

constexpr double kRoomMaxDepthM = 3.0;

/// Returns a frame whose pose is off by a shift and a rotation about its camera.
Frame Displaced(Frame frame, const Eigen::Vector3d& shift_m, const Eigen::Vector3d& turn_rad) {
  PoseError error;
  error.mean << shift_m, turn_rad;
  frame.T_world_camera = error.Correct(frame.T_world_camera);
  return frame;
}

/// A map, and the filter of one sensor in it.
class PoseFilterTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    MapStory story(PocdConfig());
    story.Play(Drive(Room(), 0, 70), 70);
    story.EndSession();
    room = new MapSnapshot(story.map());
  }

  static void TearDownTestSuite() {
    delete room;
    room = nullptr;
  }

  explicit PoseFilterTest(const MapConfig& config = PocdConfig()) : map_(config), cloud_(config) {}

  PoseError Update(const Frame& frame) {
    cloud_.Compute(frame);
    samples_.Compute(cloud_);
    const std::vector<ObjectInView> in_view = FindObjectsInView(
        map_.ObjectsNear(ReachOfView(cloud_, kRoomMaxDepthM)), cloud_, samples_, kRoomMaxDepthM);
    last_ = filter_.Update(last_, frame.capture_time, {cloud_, samples_, in_view}, map_);
    return last_->Combined();
  }

  static MapSnapshot* room;
  WorkingMap map_;
  SemanticCloud cloud_;
  SampleGrid samples_;
  PoseFilter filter_{PoseFilterParameters()};
  std::optional<PoseErrorEstimate> last_;
};

MapSnapshot* PoseFilterTest::room = nullptr;

class FinePoseFilterTest : public PoseFilterTest {
 protected:
  FinePoseFilterTest() : PoseFilterTest(FinePocdConfig()) {}
};

TEST_F(PoseFilterTest, FindsTheErrorOfAPose) {
  map_.Restore(*room);
  const Eigen::Vector3d turn_rad(0.01, -0.005, 0.015);
  for (const int index : {5, 15, 40}) {
    for (const double sign : {-1.0, 1.0}) {
      last_.reset();
      const Eigen::Vector3d shift_m = sign * Eigen::Vector3d(0.05, -0.04, 0.03);
      const Frame frame = Drive(Room(), index, 1)[0];
      const Frame claimed = Displaced(frame, shift_m, sign * turn_rad);
      const PoseError error = Update(claimed);
      const Eigen::Isometry3d corrected = error.Correct(claimed.T_world_camera);
      const Eigen::Vector3d rest_m = corrected.translation() - frame.T_world_camera.translation();
      EXPECT_LT(rest_m.norm(), 0.5 * shift_m.norm()) << index << " " << sign;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LT(std::abs(rest_m[axis]), 4.0 * std::sqrt(error.covariance(axis, axis)));
      }
    }
  }
}

TEST_F(PoseFilterTest, FindsAConstantErrorWithinAFewFrames) {
  map_.Restore(*room);
  PoseError error;
  Frame claimed;
  std::vector<Frame> frames = Drive(Room(), 0, 30);
  for (const Frame& frame : frames) {
    claimed = Displaced(frame, {0.05, -0.04, 0.03}, {0.01, -0.005, 0.015});
    error = Update(claimed);
  }
  const Eigen::Isometry3d T_true_corrected =
      frames.back().T_world_camera.inverse() * error.Correct(claimed.T_world_camera);
  EXPECT_LT(T_true_corrected.translation().norm(), 0.012);
  EXPECT_LT(Eigen::AngleAxisd(T_true_corrected.linear()).angle(), 0.005);
}

TEST_F(FinePoseFilterTest, FindsAnErrorGreaterThanTheTruncationDistance) {
  MapStory story(FinePocdConfig());
  story.Play(Drive(Room(), 0, 70), 70);
  story.EndSession();
  const MapSnapshot fine_room = story.map();
  map_.Restore(fine_room);
  // As far from the claimed pose as if the frames that made the map had been off the other way.
  const Eigen::Vector3d turn_rad(0.015, -0.01, 0.02);
  const std::vector<Frame> frames = Drive(Room(), 0, 30);
  for (const double height_m : {-0.12, 0.12}) {
    last_.reset();
    PoseError error;
    Frame claimed;
    for (const Frame& frame : frames) {
      claimed = Displaced(frame, {0.11, -0.11, height_m}, turn_rad);
      error = Update(claimed);
    }
    const Eigen::Isometry3d T_true_corrected =
        frames.back().T_world_camera.inverse() * error.Correct(claimed.T_world_camera);
    EXPECT_LT(T_true_corrected.translation().norm(), 0.01) << height_m;
    EXPECT_LT(Eigen::AngleAxisd(T_true_corrected.linear()).angle(), 0.005) << height_m;
  }
}

TEST_F(PoseFilterTest, IsNotMisledByThingsThatAreGone) {
  map_.Restore(*room);
  const Frame frame = Drive(RoomWithout(2), 15, 1)[0];
  const Frame claimed = Displaced(frame, {0.04, 0.03, 0.0}, {0.0, 0.0, 0.01});
  const PoseError error = Update(claimed);
  EXPECT_LT(
      (error.Correct(claimed.T_world_camera).translation() - frame.T_world_camera.translation())
          .norm(),
      0.02);
}

TEST_F(PoseFilterTest, FollowsAPushedThingByNoMoreThanItsPush) {
  const Scene rest = {Room()[0], testing::Body(kGoodsClass, {2.6, -0.6, 0.0}, {2.9, -0.2, 0.9})};
  const auto with_rack = [&](const Eigen::Vector3d& push_m) {
    Scene scene = rest;
    scene.push_back(testing::Body(kGoodsClass,
                                  push_m + Eigen::Vector3d(1.7, 0.2, 0.0),
                                  push_m + Eigen::Vector3d(2.3, 1.4, 1.4)));
    return scene;
  };
  MapStory story(PocdConfig());
  story.Play(Drive(with_rack(Eigen::Vector3d::Zero()), 0, 70), 70);
  story.EndSession();
  const MapSnapshot map = story.map();
  // The rack fills most of the view; the floor and a post tell that it alone has moved.
  for (const Eigen::Vector3d& push_m :
       {Eigen::Vector3d(0.08, 0.0, 0.0), Eigen::Vector3d(0.05, 0.05, 0.0)}) {
    map_.Restore(map);
    last_.reset();
    for (const Frame& frame : Drive(with_rack(push_m), 0, 70)) {
      EXPECT_LT(Update(frame).mean.head<3>().norm(), 1.2 * push_m.norm());
    }
  }
}

TEST_F(PoseFilterTest, FindsNoErrorThatThePriorRulesOut) {
  map_.Restore(*room);
  const PoseFilterParameters parameters;
  for (const Frame& frame : Drive(Room(), 0, 20)) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double shift_m : {-0.4, -0.25, 0.25, 0.4}) {
        last_.reset();
        const PoseError error =
            Update(Displaced(frame, shift_m * Eigen::Vector3d::Unit(axis), {0.0, 0.0, 0.0}));
        // 0.12 % of the errors in six degrees of freedom exceed it.
        EXPECT_LE(error.mean.head<3>().norm(), std::sqrt(22.0) * parameters.sigma_m);
      }
    }
  }
}

TEST_F(PoseFilterTest, KeepsThePriorAlongAWall) {
  MapStory story(PocdConfig());
  story.Play(LookAtScene({FarWall()}, 0, 10));
  map_.Restore(story.map());
  const Frame frame = LookAtScene({FarWall()}, 5, 1)[0];
  const Frame claimed = Displaced(frame, {0.04, 0.04, 0.04}, Eigen::Vector3d::Zero());
  const PoseError error = Update(claimed);
  // The camera looks along x; the wall tells only its distance and two rotations.
  const PoseFilterParameters parameters;
  EXPECT_NEAR(error.mean[0], -0.04, 0.01);
  EXPECT_NEAR(error.mean[1], 0.0, 0.01);
  EXPECT_NEAR(error.mean[2], 0.0, 0.01);
  EXPECT_LT(std::sqrt(error.covariance(0, 0)), 0.01);
  EXPECT_GT(std::sqrt(error.covariance(1, 1)), 0.9 * parameters.sigma_m);
  EXPECT_GT(std::sqrt(error.covariance(2, 2)), 0.9 * parameters.sigma_m);
  EXPECT_GT(std::sqrt(error.covariance(3, 3)), 0.9 * parameters.sigma_rad);
}

TEST_F(PoseFilterTest, ExtrapolatedVoxelsTellNothing) {
  const Scene wall = {testing::Body(0, {2.6, -3.0, -3.0}, {2.8, 3.0, 3.0})};
  MapStory story(PocdConfig());
  story.Play(LookAtScene(wall, 0, 10));
  const Frame claimed =
      Displaced(LookAtScene(wall, 5, 1)[0], {0.04, 0.0, 0.0}, Eigen::Vector3d::Zero());
  MapSnapshot map = story.map();
  map_.Restore(map);
  EXPECT_NEAR(Update(claimed).mean[0], -0.04, 0.01);

  std::vector<LeafOrigin> origins;
  map.background.VisitLeaves([&](LeafOrigin origin, const LeafView& /*leaf*/) {
    origins.push_back(origin);
    return true;
  });
  for (const LeafOrigin& origin : origins) {
    TsdfGrid& tile = map.background.MutableTile(origin);
    LeafVoxels voxels;
    tile.LoadLeaf(origin, &voxels);
    for (Voxel& voxel : voxels.voxels) {
      voxel = Voxel(voxel.distance_steps(), std::min(voxel.weight_units(), 1));
    }
    tile.StoreLeaf(origin, voxels);
  }
  map_.Restore(map);
  last_.reset();
  EXPECT_TRUE(Update(claimed).mean.isZero());
}

TEST_F(PoseFilterTest, TheFirstFrameDefinesTheWorldFrame) {
  const PoseError error = Update(Drive(Room(), 0, 1)[0]);
  EXPECT_TRUE(error.mean.isZero());
  EXPECT_LT(std::sqrt(error.covariance(0, 0)), 0.001);
}

TEST_F(PoseFilterTest, WithoutSurfaceTheErrorFadesIntoThePrior) {
  map_.Restore(*room);
  const Eigen::Vector3d shift_m(0.05, 0.0, 0.0);
  Frame claimed = Displaced(Drive(Room(), 15, 1)[0], shift_m, Eigen::Vector3d::Zero());
  const PoseError known = Update(claimed);
  const PoseFilterParameters parameters;
  claimed.T_world_camera.pretranslate(Eigen::Vector3d(0.0, 0.0, 50.0));
  claimed.capture_time =
      claimed.capture_time +
      Duration::FromNanoseconds(static_cast<std::int64_t>(parameters.correlation_s * 1e9));
  const PoseError faded = Update(claimed);
  EXPECT_NEAR(faded.mean[0], known.mean[0] / std::exp(1.0), 1e-6);
  EXPECT_GT(faded.covariance(0, 0), known.covariance(0, 0));
}

TEST_F(PoseFilterTest, LearnsHowGoodThePosesAre) {
  map_.Restore(*room);
  std::vector<Frame> frames = Drive(Room(), 0, 60);
  for (const Frame& frame : frames) Update(frame);
  EXPECT_GT(last_->hypotheses.back().probability, 0.5) << "exact poses";
  EXPECT_LT(last_->Combined().mean.head<3>().norm(), 0.004);

  // Drifts by 8 cm in 6 s.
  last_.reset();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double drift_m = 0.08 * static_cast<double>(i) / static_cast<double>(frames.size());
    frames[i] = Displaced(frames[i], {drift_m, 0.0, 0.0}, Eigen::Vector3d::Zero());
    Update(frames[i]);
  }
  EXPECT_GT(last_->hypotheses.front().probability, 0.5) << "drifting poses";
  EXPECT_NEAR(last_->Combined().mean[0], -0.08, 0.03);
  double sum = 0.0;
  for (const PoseErrorHypothesis& hypothesis : last_->hypotheses) sum += hypothesis.probability;
  EXPECT_NEAR(sum, 1.0, 1e-12);
}

TEST_F(PoseFilterTest, NoiseDoesNotMoveExactPoses) {
  MapStory story(PocdConfig());
  std::vector<Frame> frames = Drive(Room(), 0, 70);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    testing::AddNoise([](double depth_m) { return 0.02 * depth_m; }, i, &frames[i].depth);
    story.Play({frames[i]}, 1);
    const RobotState& robot = story.map().robots.at(frames[i].source);
    EXPECT_LT(robot.pose_error->Combined().mean.head<3>().norm(), 0.005) << i;
  }
}

TEST_F(PoseFilterTest, AFloorAtAFlatAngleTellsTheHeight) {
  const auto sigma_z = [&](DepthSensorKind sensor) {
    map_.Restore(*room);
    last_.reset();
    Frame frame = Drive(Room(), 15, 1)[0];
    frame.depth.sensor = sensor;
    return std::sqrt(Update(frame).covariance(2, 2));
  };
  // Noise along the rays hardly moves the samples off the floor.
  EXPECT_LT(sigma_z(DepthSensorKind::kStereo), 1.6 * sigma_z(DepthSensorKind::kTimeOfFlight));
}

TEST_F(PoseFilterTest, MoreFramesOfOneLookTellNoMore) {
  map_.Restore(*room);
  const Frame frame = Drive(Room(), 15, 1)[0];
  const auto sigma_after = [&](int frames, double period_s) {
    last_.reset();
    Frame one = frame;
    for (int i = 0; i < frames; ++i) {
      Update(one);
      one.capture_time =
          one.capture_time + Duration::FromNanoseconds(static_cast<std::int64_t>(period_s * 1e9));
    }
    return std::sqrt(last_->Combined().covariance(0, 0));
  };
  EXPECT_NEAR(sigma_after(61, 1.0 / 30.0) / sigma_after(11, 0.2), 1.0, 0.15);
}

}  // namespace
}  // namespace steadymap

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>

#include <gtest/gtest.h>

#include "client/bench/simulator/scene/counter_random.h"
#include "client/bench/simulator/scene/trajectory.h"
#include "client/bench/simulator/sensor/correlated_noise.h"
#include "client/bench/simulator/sensor/label_noise.h"
#include "client/bench/simulator/sensor/renderer.h"

namespace steadymap {
namespace {

constexpr PinholeCamera kNoisyCamera = {320, 180, 230.0, 230.0, 159.5, 89.5};
constexpr int kPixelCount = 320 * 180;

SensorModel Only(const std::function<void(SensorModel*)>& enable) {
  SensorModel sensor = SensorModel::Ideal();
  enable(&sensor);
  return sensor;
}

SceneObject& AddWallAt(Scene* scene, double depth_m, const Eigen::Vector2d& size_m) {
  SceneObject wall;
  wall.shape = RectangleShape{size_m};
  wall.T_world_object.translation().z() = depth_m;
  wall.semantic_class = SceneClass::kWall;
  return scene->Add(wall);
}

Frame RenderFrom(const Scene& scene, const SensorModel& sensor, const View& view) {
  Renderer renderer(&scene, kNoisyCamera, sensor);
  return renderer.Render(view, {});
}

View WithKey(std::uint64_t noise_key) { return {Eigen::Isometry3d::Identity(), 0, noise_key}; }

struct Statistics {
  double mean = 0.0;
  double sigma = 0.0;
};

Statistics StatisticsOf(const Image<std::uint16_t>& image) {
  double sum = 0.0;
  double square_sum = 0.0;
  for (std::size_t i = 0; i < image.size(); ++i) {
    sum += image.data()[i];
    square_sum += double{1.0} * image.data()[i] * image.data()[i];
  }
  const auto count = static_cast<double>(image.size());
  return {sum / count, std::sqrt(square_sum / count - sum * sum / count / count)};
}

double ShareOf(const Image<std::uint16_t>& image, std::uint16_t value) {
  const auto count = std::count(image.data(), image.data() + image.size(), value);
  return static_cast<double>(count) / static_cast<double>(image.size());
}

TEST(DepthNoise, SigmaIsTwoMillimetresAtOneMetreAndTwoPercentAtFour) {
  struct Case {
    double depth_m;
    double sigma_mm;
  };

  const SensorModel sensor = Only([](SensorModel* s) { s->depth_noise = true; });
  for (const Case& c : {Case{0.5, 0.5}, Case{1.0, 2.0}, Case{2.0, 17.6}, Case{4.0, 80.0}}) {
    Scene scene;
    AddWallAt(&scene, c.depth_m, {50, 50});
    const Statistics found = StatisticsOf(RenderFrom(scene, sensor, WithKey(7)).depth.units);
    EXPECT_NEAR(found.mean, 1000 * c.depth_m, 4 * c.sigma_mm / std::sqrt(kPixelCount) + 0.1);
    // Rounding to millimetres adds a variance of 1/12.
    EXPECT_NEAR(found.sigma, std::sqrt(c.sigma_mm * c.sigma_mm + 1.0 / 12), 0.03 * c.sigma_mm);
  }
}

TEST(DepthNoise, NeighbouringPixelsAndFramesAreIndependent) {
  Scene scene;
  AddWallAt(&scene, 2.0, {50, 50});
  const SensorModel sensor = Only([](SensorModel* s) { s->depth_noise = true; });
  const Image<std::uint16_t> first = RenderFrom(scene, sensor, WithKey(1)).depth.units;
  const Image<std::uint16_t> second = RenderFrom(scene, sensor, WithKey(2)).depth.units;
  double beside = 0.0;
  double between = 0.0;
  double variance = 0.0;
  for (std::size_t i = 1; i < first.size(); ++i) {
    const double noise = first.data()[i] - 2000.0;
    variance += noise * noise;
    beside += noise * (first.data()[i - 1] - 2000.0);
    between += noise * (second.data()[i] - 2000.0);
  }
  EXPECT_LT(std::abs(beside / variance), 0.02);
  EXPECT_LT(std::abs(between / variance), 0.02);
}

/// Returns the field at a pixel and time.
float ValueOf(std::uint64_t key,
              const std::array<int, 2>& pixel,
              double time_s,
              CorrelatedNoise* noise) {
  noise->SetMoment(key, time_s);
  return noise->Row(pixel[1])[static_cast<std::size_t>(pixel[0])];
}

/// Returns the mean product of two values of the field, over many keys.
double CorrelationOf(const std::array<int, 2>& pixel,
                     double time_s,
                     const std::array<int, 2>& other_pixel,
                     double other_time_s) {
  constexpr int kDraws = 4000;
  CorrelatedNoise noise(320, 180);
  double sum = 0.0;
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const std::uint64_t key = Scramble(i);
    const float product =
        ValueOf(key, pixel, time_s, &noise) * ValueOf(key, other_pixel, other_time_s, &noise);
    sum += static_cast<double>(product);
  }
  return sum / kDraws;
}

TEST(CorrelatedNoise, HasVarianceOneEverywhere) {
  EXPECT_NEAR(CorrelationOf({0, 0}, 0.0, {0, 0}, 0.0), 1.0, 0.1);
  EXPECT_NEAR(CorrelationOf({16, 16}, 0.5, {16, 16}, 0.5), 1.0, 0.1);
  EXPECT_NEAR(CorrelationOf({319, 179}, 3.3, {319, 179}, 3.3), 1.0, 0.1);
}

TEST(CorrelatedNoise, FadesWithinTwoSpacingsAndTwoPeriods) {
  EXPECT_GT(CorrelationOf({100, 90}, 0.4, {104, 90}, 0.4), 0.9);
  EXPECT_GT(CorrelationOf({100, 90}, 0.4, {100, 86}, 0.5), 0.85);
  EXPECT_NEAR(CorrelationOf({100, 90}, 0.4, {164, 90}, 0.4), 0.0, 0.1);
  EXPECT_NEAR(CorrelationOf({100, 90}, 0.4, {100, 154}, 0.4), 0.0, 0.1);
  EXPECT_NEAR(CorrelationOf({100, 90}, 0.4, {100, 90}, 2.4), 0.0, 0.1);
}

TEST(CorrelatedNoise, ShiftsAWallByItsShareOfSigma) {
  Scene scene;
  AddWallAt(&scene, 2.0, {50, 50});
  SensorModel sensor = Only([](SensorModel* s) { s->correlated_noise = true; });
  sensor.correlated_noise_share = 0.5;
  double square_sum = 0.0;
  constexpr int kDraws = 200;
  for (std::uint64_t key = 0; key < kDraws; ++key) {
    View view = WithKey(1);
    view.slow_noise_key = Scramble(key);
    const Image<std::uint16_t> depth = RenderFrom(scene, sensor, view).depth.units;
    const double shift_mm = depth.At(160, 90) - 2000.0;
    EXPECT_NEAR(depth.At(161, 90), depth.At(160, 90), 2.0);
    square_sum += shift_mm * shift_mm;
  }
  EXPECT_NEAR(std::sqrt(square_sum / kDraws), 0.5 * 17.6, 1.5);
}

TEST(ForegroundFattening, WidensTheNearerSurfaceByItsWidth) {
  Scene scene;
  AddWallAt(&scene, 2.0, {50, 50});
  AddWallAt(&scene, 1.0, {0.4, 50});
  const SensorModel sensor = Only([](SensorModel* s) { s->foreground_fattening = true; });
  const Image<std::uint16_t> ideal =
      RenderFrom(scene, SensorModel::Ideal(), WithKey(1)).depth.units;
  const Image<std::uint16_t> fat = RenderFrom(scene, sensor, WithKey(1)).depth.units;
  for (int v = 0; v < 180; ++v) {
    for (int u = 0; u < 320; ++u) {
      bool is_beside = false;
      for (int other = std::max(u - 2, 0); other <= std::min(u + 2, 319); ++other) {
        is_beside = is_beside || ideal.At(other, v) == 1000;
      }
      ASSERT_EQ(fat.At(u, v), is_beside ? 1000 : 2000) << u << ", " << v;
    }
  }
  EXPECT_GT(ShareOf(fat, 1000), ShareOf(ideal, 1000));
}

TEST(DisparitySteps, EveryDepthIsAWholeNumberOfSteps) {
  Scene scene;
  AddFloor(&scene, {50, 50});
  const SensorModel sensor = Only([](SensorModel* s) { s->disparity_steps = true; });
  View view;
  view.T_world_camera = LookAt({0, 0, 1.5}, {1.5, 0, 0});
  const Frame frame = RenderFrom(scene, sensor, view);
  const Frame ideal = RenderFrom(scene, SensorModel::Ideal(), view);
  const double step_metres = kNoisyCamera.fx * sensor.stereo_baseline_m / sensor.disparity_step_px;
  for (int v = 0; v < kNoisyCamera.height_px; ++v) {
    for (int u = 0; u < kNoisyCamera.width_px; ++u) {
      const double depth_m = frame.depth.units.At(u, v) * 0.001;
      if (depth_m == 0) continue;
      const double steps = std::round(step_metres / depth_m);
      ASSERT_NEAR(depth_m, step_metres / steps, 0.00051);
      if (ideal.depth.units.At(u, v) == 0) continue;
      const double half_step_m = depth_m * depth_m / step_metres * 0.55;
      ASSERT_NEAR(depth_m, ideal.depth.units.At(u, v) * 0.001, half_step_m + 0.001);
    }
  }
  const std::set<std::uint16_t> levels(frame.depth.units.data(),
                                       frame.depth.units.data() + frame.depth.units.size());
  EXPECT_GT(levels.size(), 20U);
}

TEST(FlyingPixels, FloatBetweenTheSurfacesAtEdgesOnly) {
  Scene scene;
  AddWallAt(&scene, 3.0, {50, 50});
  AddWallAt(&scene, 1.0, {0.4, 0.3});
  const SensorModel sensor = Only([](SensorModel* s) { s->flying_pixels = true; });
  const Image<std::uint16_t> depth = RenderFrom(scene, sensor, WithKey(3)).depth.units;
  const Image<std::uint16_t> ideal =
      RenderFrom(scene, SensorModel::Ideal(), WithKey(3)).depth.units;
  int edge_count = 0;
  int flying_count = 0;
  for (int v = 1; v + 1 < kNoisyCamera.height_px; ++v) {
    for (int u = 1; u + 1 < kNoisyCamera.width_px; ++u) {
      const std::uint16_t own = ideal.At(u, v);
      const bool is_edge = ideal.At(u - 1, v) != own || ideal.At(u + 1, v) != own ||
                           ideal.At(u, v - 1) != own || ideal.At(u, v + 1) != own;
      edge_count += is_edge ? 1 : 0;
      if (depth.At(u, v) == own) continue;
      ++flying_count;
      ASSERT_TRUE(is_edge) << u << " " << v;
      ASSERT_GE(depth.At(u, v), 1000);
      ASSERT_LE(depth.At(u, v), 3000);
    }
  }
  EXPECT_GT(edge_count, 500);
  EXPECT_NEAR(static_cast<double>(flying_count) / edge_count, sensor.flying_pixel_share, 0.06);
}

TEST(GrazingDropout, LossGrowsFromTheLimitToFlat) {
  Scene scene;
  AddFloor(&scene, {100, 100});
  const SensorModel sensor = Only([](SensorModel* s) { s->grazing_dropout = true; });
  View view;
  view.T_world_camera = LookAt({0, 0, 0.4}, {3, 0, 0});
  const Frame frame = RenderFrom(scene, sensor, view);
  const Frame ideal = RenderFrom(scene, SensorModel::Ideal(), view);
  int kept_count = 0;
  double expected_count = 0.0;
  int grazing_count = 0;
  for (int v = 0; v < kNoisyCamera.height_px; ++v) {
    for (int u = 0; u < kNoisyCamera.width_px; ++u) {
      if (ideal.depth.units.At(u, v) == 0) continue;
      const Eigen::Vector3d ray =
          view.T_world_camera.linear() * kNoisyCamera.Ray(u, v).normalized();
      const bool is_kept = frame.depth.units.At(u, v) != 0;
      if (-ray.z() >= sensor.grazing_cosine) {
        ASSERT_TRUE(is_kept);
        continue;
      }
      ++grazing_count;
      kept_count += is_kept ? 1 : 0;
      expected_count += -ray.z() / sensor.grazing_cosine;
    }
  }
  EXPECT_GT(grazing_count, 2000);
  EXPECT_NEAR(kept_count / expected_count, 1.0, 0.03);
}

TEST(Holes, TakeTwoToFivePercentOfEachFrame) {
  Scene scene;
  AddWallAt(&scene, 2.0, {50, 50});
  const SensorModel sensor = Only([](SensorModel* s) { s->holes = true; });
  double sum = 0.0;
  for (std::uint64_t key = 0; key < 60; ++key) {
    const double share = ShareOf(RenderFrom(scene, sensor, WithKey(key)).depth.units, kNoDepth);
    // The last hole may exceed the share; overlaps count once.
    EXPECT_GT(share, 0.0185);
    EXPECT_LT(share, 0.055);
    sum += share;
  }
  EXPECT_NEAR(sum / 60, 0.035, 0.004);
}

TEST(LabelBoundaryNoise, FivePercentOfTheBandBesideABorderSwap) {
  Scene scene;
  AddWallAt(&scene, 3.0, {50, 50});
  AddWallAt(&scene, 1.0, {0.6, 50}).semantic_class = SceneClass::kGoods;
  const SensorModel sensor = Only([](SensorModel* s) { s->label_boundary_noise = true; });
  const Image<std::uint16_t> truth = RenderFrom(scene, SensorModel::Ideal(), WithKey(0)).labels;
  int band_count = 0;
  int swapped_count = 0;
  for (std::uint64_t key = 0; key < 20; ++key) {
    const Image<std::uint16_t> labels = RenderFrom(scene, sensor, WithKey(key)).labels;
    for (int v = 0; v < kNoisyCamera.height_px; ++v) {
      for (int u = 2; u + 2 < kNoisyCamera.width_px; ++u) {
        const std::uint16_t own = truth.At(u, v);
        const bool in_band = truth.At(u - 2, v) != own || truth.At(u + 2, v) != own;
        band_count += in_band ? 1 : 0;
        if (labels.At(u, v) == own) continue;
        ++swapped_count;
        ASSERT_TRUE(in_band) << u << " " << v;
      }
    }
  }
  EXPECT_NEAR(static_cast<double>(swapped_count) / band_count, 0.05, 0.005);
}

TEST(LabelBlobs, OnePatchAFrameOnAverage) {
  Scene scene;
  AddWallAt(&scene, 2.0, {50, 50});
  const SensorModel sensor = Only([](SensorModel* s) { s->label_blobs = true; });
  int clean_count = 0;
  for (std::uint64_t key = 0; key < 300; ++key) {
    const Image<std::uint16_t> labels = RenderFrom(scene, sensor, WithKey(key)).labels;
    const double wrong = 1 - ShareOf(labels, 4);
    clean_count += wrong == 0 ? 1 : 0;
    EXPECT_LT(wrong, 0.2);
    EXPECT_LT(*std::max_element(labels.data(), labels.data() + labels.size()), kSceneClassCount);
  }
  // Four chances of a quarter each; a patch of the wall's own class or outside the picture has no
  // effect.
  EXPECT_NEAR(clean_count / 300.0, std::pow(1 - 0.25 * 14 / 15, 4), 0.08);
}

TEST(LabelFlips, OnePercentOfTheObjectsAndNeverTheFloor) {
  const SensorModel sensor = Only([](SensorModel* s) { s->label_flips = true; });
  SceneObject box;
  box.semantic_class = SceneClass::kGoods;
  box.id = 5;
  box.instance = 5;
  SceneObject floor = box;
  floor.instance = 0;
  int flip_count = 0;
  for (std::uint64_t key = 0; key < 50'000; ++key) {
    const std::uint16_t shown = ShownClass(sensor, Scramble(key), box);
    EXPECT_LT(shown, kSceneClassCount);
    flip_count += shown != 7 ? 1 : 0;
    ASSERT_EQ(ShownClass(sensor, Scramble(key), floor), 7);
  }
  EXPECT_NEAR(flip_count / 50'000.0, sensor.label_flip_share, 0.002);
}

TEST(LabelFlips, TakeClassZeroAsOftenAsTheModelSays) {
  SensorModel sensor = Only([](SensorModel* s) { s->label_flips = true; });
  sensor.label_flip_share = 1.0;
  sensor.unlabelled_share = 0.3;
  SceneObject box;
  box.semantic_class = SceneClass::kGoods;
  box.id = 5;
  box.instance = 5;
  int zero_count = 0;
  for (std::uint64_t key = 0; key < 20'000; ++key) {
    zero_count += ShownClass(sensor, Scramble(key), box) == 0 ? 1 : 0;
  }
  EXPECT_NEAR(zero_count / 20'000.0, 0.3, 0.015);
}

TEST(LabelFlips, ChangeTheWholeObject) {
  Scene scene;
  SceneObject& box = AddWallAt(&scene, 1.0, {50, 50});
  box.instance = box.id;
  SensorModel sensor = Only([](SensorModel* s) { s->label_flips = true; });
  sensor.label_flip_share = 1.0;
  const Image<std::uint16_t> labels = RenderFrom(scene, sensor, WithKey(1)).labels;
  EXPECT_NE(labels.At(0, 0), 4);
  EXPECT_EQ(ShareOf(labels, labels.At(0, 0)), 1.0);
}

TEST(DriftPose, IsBoundedSmoothAndOfTheSeed) {
  const SensorModel sensor = SensorModel::Full();
  const Eigen::Isometry3d T_true = LookAt({3, 2, 1}, {0, 0, 0});
  double largest_m = 0.0;
  double largest_rad = 0.0;
  Eigen::Vector3d last = DriftPose(sensor, 1, 0, T_true).translation();
  for (int i = 0; i < 3000; ++i) {
    const double time_s = i * 0.1;
    const Eigen::Isometry3d drifted = DriftPose(sensor, 1, time_s, T_true);
    const Eigen::Vector3d offset_m = drifted.translation() - T_true.translation();
    largest_m = std::max(largest_m, offset_m.cwiseAbs().maxCoeff());
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(drifted.linear() * T_true.linear().transpose()));
    largest_rad = std::max(largest_rad, turn.angle());
    // At most amplitude * 2 pi / shortest period along each axis.
    ASSERT_LT((drifted.translation() - last).norm(), 0.001);
    last = drifted.translation();
  }
  EXPECT_LE(largest_m, 0.015);
  EXPECT_GE(largest_m, 0.0075);
  EXPECT_LE(largest_rad, 0.0087 * std::sqrt(3.0) + 1e-4);
  EXPECT_GE(largest_rad, 0.004);
  EXPECT_FALSE(DriftPose(sensor, 1, 5, T_true).isApprox(DriftPose(sensor, 2, 5, T_true), 1e-6));
  EXPECT_TRUE(DriftPose(SensorModel::Ideal(), 1, 5, T_true).matrix() == T_true.matrix());
}

TEST(WalkPose, GrowsWithTheSquareRootOfTime) {
  SensorModel sensor;
  sensor.pose_walk_m = 0.01;
  sensor.pose_walk_rad = 0.002;
  const Eigen::Isometry3d T_true = LookAt({3, 2, 1}, {0, 0, 0});
  EXPECT_TRUE(WalkPose(sensor, 1, 0, 0.0, T_true).isApprox(T_true, 1e-12));
  for (const double time_s : {1.0, 25.0, 100.0}) {
    double shift_square_sum = 0.0;
    double turn_square_sum = 0.0;
    constexpr int kSeeds = 2000;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const Eigen::Isometry3d walked = WalkPose(sensor, seed, 1, time_s, T_true);
      shift_square_sum += (walked.translation() - T_true.translation()).squaredNorm() / 3.0;
      const double turn_rad =
          Eigen::AngleAxisd(Eigen::Matrix3d(walked.linear() * T_true.linear().transpose())).angle();
      turn_square_sum += turn_rad * turn_rad;
    }
    const double growth = std::sqrt(time_s);
    EXPECT_NEAR(std::sqrt(shift_square_sum / kSeeds), 0.01 * growth, 0.0005 * growth);
    EXPECT_NEAR(std::sqrt(turn_square_sum / kSeeds), 0.002 * growth, 0.00015 * growth);
  }
}

TEST(WalkPose, IsContinuousAndOfSeedAndSequence) {
  SensorModel sensor;
  sensor.pose_walk_m = 0.01;
  const Eigen::Isometry3d T_true = LookAt({3, 2, 1}, {0, 0, 0});
  Eigen::Vector3d last = T_true.translation();
  for (int i = 1; i < 300; ++i) {
    const Eigen::Vector3d place = WalkPose(sensor, 1, 0, 0.1 * i, T_true).translation();
    // At most 0.1 s of steps along each axis.
    ASSERT_LE((place - last).norm(), 0.01 * 0.1 * 3.0 + 1e-12);
    last = place;
  }
  const Eigen::Isometry3d walked = WalkPose(sensor, 1, 0, 9.0, T_true);
  EXPECT_FALSE(walked.isApprox(WalkPose(sensor, 2, 0, 9.0, T_true), 1e-6));
  EXPECT_FALSE(walked.isApprox(WalkPose(sensor, 1, 1, 9.0, T_true), 1e-6));
  EXPECT_TRUE(WalkPose(SensorModel::Full(), 1, 0, 9.0, T_true).matrix() == T_true.matrix());
}

TEST(OffsetPose, IsConstantInASequenceAndZeroInTheFirst) {
  SensorModel sensor;
  sensor.session_offset_m = 0.05;
  sensor.session_offset_rad = 0.02;
  const Eigen::Isometry3d T_true = LookAt({3, 2, 1}, {0, 0, 0});
  EXPECT_TRUE(OffsetPose(sensor, 1, 0, T_true).matrix() == T_true.matrix());
  const Eigen::Isometry3d T_shift = OffsetPose(sensor, 1, 1, T_true) * T_true.inverse();
  EXPECT_NEAR(T_shift.translation().norm(), 0.05, 1e-12);
  EXPECT_NEAR(Eigen::AngleAxisd(T_shift.linear()).angle(), 0.02, 1e-12);
  const Eigen::Isometry3d T_other = LookAt({-1, 2, 1}, {0, 0, 0});
  EXPECT_TRUE(T_shift.isApprox(OffsetPose(sensor, 1, 1, T_other) * T_other.inverse(), 1e-12));
  EXPECT_FALSE(T_shift.isApprox(OffsetPose(sensor, 1, 2, T_true) * T_true.inverse(), 1e-6));
}

TEST(SensorModel, EachSwitchTouchesOnlyItsOwnImage) {
  Scene scene;
  AddFloor(&scene, {30, 30});
  SceneObject& box = AddStandingBox(&scene, "box", {0.5, 0.5, 1.0}, {1.5, 0, 0.3});
  ASSERT_EQ(box.instance, box.id);
  SensorModel flips = Only([](SensorModel* s) { s->label_flips = true; });
  flips.label_flip_share = 1.0;
  SensorModel blobs = Only([](SensorModel* s) { s->label_blobs = true; });
  blobs.label_blobs_a_frame = 4;
  View view;
  view.T_world_camera = LookAt({0, 0, 0.5}, {2, 0, 0.3});
  const Frame ideal = RenderFrom(scene, SensorModel::Ideal(), view);
  for (const SensorModel& sensor : {Only([](SensorModel* s) { s->depth_noise = true; }),
                                    Only([](SensorModel* s) { s->correlated_noise = true; }),
                                    Only([](SensorModel* s) { s->disparity_steps = true; }),
                                    Only([](SensorModel* s) { s->flying_pixels = true; }),
                                    Only([](SensorModel* s) { s->grazing_dropout = true; }),
                                    Only([](SensorModel* s) { s->holes = true; })}) {
    const Frame frame = RenderFrom(scene, sensor, view);
    EXPECT_FALSE(frame.depth == ideal.depth);
    EXPECT_TRUE(frame.labels == ideal.labels);
  }
  for (const SensorModel& sensor :
       {flips, blobs, Only([](SensorModel* s) { s->label_boundary_noise = true; })}) {
    const Frame frame = RenderFrom(scene, sensor, view);
    EXPECT_TRUE(frame.depth == ideal.depth);
    EXPECT_FALSE(frame.labels == ideal.labels);
  }
}

}  // namespace
}  // namespace steadymap

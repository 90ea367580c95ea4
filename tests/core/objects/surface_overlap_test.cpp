#include "core/objects/surface_overlap.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;
using ::steadymap::testing::StateOf;
using ::steadymap::testing::StoreVolume;

constexpr ClassId kClass{7};
constexpr SurfaceMatchParameters kParameters;

/// Returns the front of a box that faces -x at `face_m`, from `y_m` along y, 1 m high. If
/// `is_whole`, all voxels of the leaves that the width intersects are observed, else only those
/// within the width.
TrackedObject Front(
    std::uint64_t id, double y_m, double width_m, bool is_whole = true, double face_m = 0.2) {
  const double leaf_m = kScale.leaf_size_m();
  TrackedObject object(ObjectId(id), {0.0, std::floor(y_m / leaf_m) * leaf_m, 0.0}, kScale);
  const double first_m = y_m - object.state().T_world_object.position_world.y();
  StoreVolume(
      testing::MakeVolume(
          [&](const Eigen::Vector3d& point) { return face_m - point.x(); },
          Box(Eigen::Vector3d(0.05, first_m, 0.0), Eigen::Vector3d(0.35, first_m + width_m, 1.0)),
          kScale,
          [&](const Eigen::Vector3d& point) {
            return is_whole || (point.y() > first_m - 1e-6 && point.y() < first_m + width_m + 1e-6);
          }),
      &object);
  StateOf(&object).class_id = kClass;
  return object;
}

SurfaceOverlap Compare(const TrackedObject& object, const TrackedObject& other) {
  const Eigen::Isometry3d T_other_object = other.state().T_world_object.ToIsometry().inverse() *
                                           object.state().T_world_object.ToIsometry();
  return CompareSurfaces(object, other, T_other_object, kParameters, kScale);
}

TEST(CompareSurfaces, IsWholeForTheSameSurface) {
  const SurfaceOverlap overlap = Compare(Front(1, 0.0, 0.8), Front(2, 0.0, 0.8));
  EXPECT_NEAR(overlap.known_share, 1.0, 1e-9);
  EXPECT_NEAR(overlap.fit_share, 1.0, 1e-9);
}

TEST(CompareInPlace, TellsADisplacementOfThreeCentimetres) {
  const TrackedObject known = Front(1, 0.0, 0.8);
  EXPECT_NEAR(
      CompareInPlace(Front(2, 0.0, 0.8), known, kParameters, kScale).close_share(), 1.0, 1e-9);
  TrackedObject displaced = Front(3, 0.0, 0.8);
  StateOf(&displaced).T_world_object.position_world.x() += 0.03;
  EXPECT_NEAR(CompareInPlace(displaced, known, kParameters, kScale).close_share(), 0.0, 1e-9);
}

TEST(CompareInPlace, SidesOfAThinThingDoNotContradictEachOther) {
  const TrackedObject front = Front(1, 0.0, 0.8);
  // The back of a board of 4 cm, which faces +x.
  TrackedObject back = Front(2, 0.0, 0.8);
  StateOf(&back).T_world_object.position_world += Eigen::Vector3d(0.44, 0.8, 0.0);
  StateOf(&back).T_world_object.yaw_rad = M_PI;
  const MutualOverlap sides = CompareInPlace(front, back, kParameters, kScale);
  EXPECT_LT(sides.overlap.known_share, 0.15);
  EXPECT_GT(sides.expected_share(1.0), 0.9);
  EXPECT_GT(Compare(front, back).known_share, 0.6);
}

TEST(CompareSurfaces, KnowsOnlyThePartThatOverlaps) {
  const SurfaceOverlap overlap = Compare(Front(1, 0.0, 3.2), Front(2, 1.6, 3.2));
  EXPECT_NEAR(overlap.known_share, 0.5, 0.08);
  EXPECT_NEAR(overlap.fit_share, 1.0, 1e-9);
}

TEST(CompareSurfaces, WhatIsNotKnownAgreesWithSomeOdds) {
  const SurfaceOverlap overlap = Compare(Front(1, 0.0, 3.2), Front(2, 1.6, 3.2));
  EXPECT_NEAR(overlap.expected_share(0.5), 0.75, 0.04);
  EXPECT_NEAR(overlap.expected_share(1.0), 1.0, 1e-9);
  EXPECT_NEAR(SurfaceOverlap().expected_share(0.5), 0.5, 1e-9);
}

TEST(CompareSurfaces, FitsNothingThatLiesTooFarInFront) {
  const TrackedObject object = Front(1, 0.0, 0.8);
  const Eigen::Isometry3d T_other_object(Eigen::Translation3d(-0.1, 0.0, 0.0));
  const SurfaceOverlap overlap =
      CompareSurfaces(object, Front(2, 0.0, 0.8), T_other_object, kParameters, kScale);
  EXPECT_GT(overlap.known_share, 0.9);
  EXPECT_EQ(overlap.fit_share, 0.0);
}

TEST(CompareSurfaces, IsCloseWithinThreeStandardDeviations) {
  const TrackedObject object = Front(1, 0.0, 0.8);
  for (const double sigmas : {2.7, 3.3}) {
    const Eigen::Isometry3d T_other_object(
        Eigen::Translation3d(-sigmas * SurfaceSigmaM(kParameters, kScale), 0.0, 0.0));
    const SurfaceOverlap overlap =
        CompareSurfaces(object, Front(2, 0.0, 0.8), T_other_object, kParameters, kScale);
    EXPECT_NEAR(overlap.fit_share, 1.0, 1e-9) << sigmas;
    EXPECT_NEAR(overlap.close_share, sigmas < 3.0 ? 1.0 : 0.0, 1e-9) << sigmas;
  }
}

TEST(CompareSurfaces, IsCloseToAThinThingBetweenItsVoxels) {
  const double face_m = 0.2 - 0.49 * kScale.voxel_size_m;
  const TrackedObject thin = Front(2, 0.0, 0.0, /*is_whole=*/false, face_m);
  const SurfaceOverlap overlap =
      CompareSurfaces(Front(1, 0.0, 0.8),
                      thin,
                      Eigen::Isometry3d(Eigen::Translation3d(face_m - 0.2, 0.0, 0.0)),
                      kParameters,
                      kScale);
  EXPECT_GT(overlap.known_share, 0.0);
  EXPECT_NEAR(overlap.close_share, 1.0, 1e-9);
}

TEST(CompareSurfaces, FitsNothingThatFacesTheOtherWay) {
  const TrackedObject object = Front(1, 0.0, 0.8);
  // The rotation is about the centre of the front, so that the surface coincides with itself.
  const Eigen::Isometry3d T_other_object = Eigen::Translation3d(0.2, 0.4, 0.0) *
                                           Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()) *
                                           Eigen::Translation3d(-0.2, -0.4, 0.0);
  const SurfaceOverlap overlap =
      CompareSurfaces(object, Front(2, 0.0, 0.8), T_other_object, kParameters, kScale);
  EXPECT_GT(overlap.known_share, 0.6);
  EXPECT_LT(overlap.fit_share, 0.1);
}

TEST(CompareSurfaces, IsNothingWithoutSurface) {
  const TrackedObject nothing(ObjectId(1), Eigen::Vector3d::Zero(), kScale);
  const SurfaceOverlap overlap = Compare(nothing, Front(2, 0.0, 0.8));
  EXPECT_EQ(overlap.known_share, 0.0);
  EXPECT_EQ(overlap.fit_share, 0.0);
}

}  // namespace
}  // namespace steadymap

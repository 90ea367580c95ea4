#include "client/picture/birds_eye.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "client/picture/birds_eye_objects.h"
#include "client/picture/height_ramp.h"
#include "client/picture/picture_style.h"
#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kNan;

constexpr Rgb kInk = {45, 48, 54};

// Adds the parallelogram `corner`, `corner + a`, `corner + b`, which faces along a x b.
void AddPatch(const Eigen::Vector3f& corner,
              const Eigen::Vector3f& a,
              const Eigen::Vector3f& b,
              Mesh* mesh) {
  const auto first = static_cast<std::uint32_t>(mesh->vertices_world.size());
  const Eigen::Vector3f normal = a.cross(b).normalized();
  for (const Eigen::Vector3f& offset : {Eigen::Vector3f(0, 0, 0), a, Eigen::Vector3f(a + b), b}) {
    mesh->vertices_world.emplace_back(corner + offset);
    mesh->normals_world.push_back(normal);
  }
  mesh->triangles.insert(mesh->triangles.end(),
                         {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
}

void AddFloor(const Eigen::Vector2f& low, const Eigen::Vector2f& high, float z, Mesh* mesh) {
  AddPatch({low.x(), low.y(), z}, {high.x() - low.x(), 0, 0}, {0, high.y() - low.y(), 0}, mesh);
}

void AddCeiling(const Eigen::Vector2f& low, const Eigen::Vector2f& high, float z, Mesh* mesh) {
  AddPatch({low.x(), low.y(), z}, {0, high.y() - low.y(), 0}, {high.x() - low.x(), 0, 0}, mesh);
}

// A floor of 8 m x 4 m around the origin with a box top of 1 m x 1 m, 2 m high, at (2, 1).
Mesh Room() {
  Mesh mesh;
  AddFloor({-4, -2}, {4, 2}, 0.0F, &mesh);
  AddFloor({1.5F, 0.5F}, {2.5F, 1.5F}, 2.0F, &mesh);
  return mesh;
}

Rgb PixelAt(const BirdsEyePicture& picture, double x, double y) {
  const Eigen::Vector2d pixel = picture.view.PixelOf({x, y});
  return picture.image.At(static_cast<int>(std::floor(pixel.x())),
                          static_cast<int>(std::floor(pixel.y())));
}

// Returns the sum of the channels' differences.
int Difference(const Rgb& a, const Rgb& b) {
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
}

// Returns the colour without brightness: shading must not change it.
Eigen::Vector3d Hue(const Rgb& color) {
  return Eigen::Vector3d(color[0], color[1], color[2]).normalized();
}

TEST(DrawBirdsEye, ShowsABoxWhereItStandsInTheColourOfItsHeight) {
  const BirdsEyePicture picture = DrawBirdsEye(Room(), {}, {});
  for (const double x : {1.55, 2.0, 2.45}) {
    for (const double y : {0.55, 1.0, 1.45}) {
      EXPECT_LT((Hue(PixelAt(picture, x, y)) - Hue(HeightColor(1.0))).norm(), 0.03)
          << x << " " << y;
    }
  }
  for (const Eigen::Vector2d& floor :
       {Eigen::Vector2d(1.4, 1.0), {2.6, 1.0}, {2.0, 0.4}, {2.0, 1.6}, {-3.9, -1.9}}) {
    EXPECT_LT((Hue(PixelAt(picture, floor.x(), floor.y())) - Hue(HeightColor(0.0))).norm(), 0.03)
        << floor.transpose();
  }
  EXPECT_GT(Difference(HeightColor(0.0), kWhite), 60);
  EXPECT_EQ(PixelAt(picture, 4.1, 0.03), kWhite);
}

TEST(DrawBirdsEye, ShowsTheMeshsColoursWhereItHasThemUnlessToldOtherwise) {
  Mesh mesh = Room();
  mesh.colors.assign(mesh.vertices_world.size(), Rgb{200, 30, 30});
  const Rgb shown = PixelAt(DrawBirdsEye(mesh, {}, {}), 0.0, 0.0);
  EXPECT_LT((Hue(shown) - Hue({200, 30, 30})).norm(), 0.02);
  const Rgb height = PixelAt(DrawBirdsEye(mesh, {}, {.use_mesh_colors = false}), 0.0, 0.0);
  EXPECT_LT((Hue(height) - Hue(HeightColor(0.0))).norm(), 0.03);
}

TEST(DrawBirdsEye, MakesTheLongerSideAsLongAsAsked) {
  for (const int side_px : {600, 1200, 2000}) {
    const BirdsEyePicture wide = DrawBirdsEye(Room(), {}, {.longest_side_px = side_px});
    EXPECT_EQ(wide.image.width_px(), side_px);
    EXPECT_LT(wide.image.height_px(), side_px);
    EXPECT_EQ(wide.view.width_px, wide.image.width_px());
    EXPECT_EQ(wide.view.height_px, wide.image.height_px());
  }
  Mesh tall;
  AddFloor({0, 0}, {3, 9}, 0.0F, &tall);
  EXPECT_EQ(DrawBirdsEye(tall, {}, {}).image.height_px(), 1200);
}

TEST(DrawBirdsEye, DrawsAScaleBarOfTheLengthItNames) {
  for (const float size_m : {0.4F, 3.0F, 17.0F, 400.0F}) {
    Mesh mesh;
    AddFloor({0, 0}, {size_m, size_m / 2}, 0.0F, &mesh);
    const BirdsEyePicture picture = DrawBirdsEye(mesh, {}, {});
    int length_px = 0;
    while (picture.image.At(picture.scale_bar_px.x() + length_px, picture.scale_bar_px.y()) ==
           kInk) {
      ++length_px;
    }
    EXPECT_NEAR(length_px, picture.scale_bar_m / picture.view.metres_per_px, 1.0) << size_m;
    EXPECT_GT(length_px, 100);
    // 1, 2 or 5 times a power of ten.
    const double power = std::pow(10.0, std::floor(std::log10(picture.scale_bar_m) + 1e-9));
    const double leading = picture.scale_bar_m / power;
    EXPECT_LT(std::min({std::abs(leading - 1), std::abs(leading - 2), std::abs(leading - 5)}),
              1e-9);
  }
}

TEST(DrawBirdsEye, ShowsWallsThoughTheyAreSeenEdgeOn) {
  Mesh mesh;
  AddFloor({-2, -2}, {2, 2}, 0.0F, &mesh);
  AddPatch({-1, 1, 0}, {2, 0, 0}, {0, 0, 2.5F}, &mesh);
  const BirdsEyePicture picture = DrawBirdsEye(mesh, {}, {});
  EXPECT_GT(Difference(PixelAt(picture, 0.0, 1.0), PixelAt(picture, 0.0, 0.0)), 150);
}

TEST(DrawBirdsEye, LooksThroughACeiling) {
  Mesh mesh = Room();
  AddCeiling({-4, -2}, {4, 2}, 3.0F, &mesh);
  // A lamp under the roof, without upward-facing surface except a stray return.
  AddFloor({-3, -1}, {-2, 0}, 3.1F, &mesh);
  const BirdsEyePicture picture = DrawBirdsEye(mesh, {}, {});
  ASSERT_TRUE(picture.cut_height_m.has_value());
  EXPECT_NEAR(*picture.cut_height_m, 2.9, 0.11);
  EXPECT_EQ(PixelAt(picture, -2.5, -0.5), PixelAt(DrawBirdsEye(Room(), {}, {}), -2.5, -0.5));
}

TEST(DrawBirdsEye, LeavesOutWhatIsAboveAGivenCut) {
  const BirdsEyePicture picture = DrawBirdsEye(Room(), {}, {.cut_height_m = 1.0});
  EXPECT_EQ(picture.cut_height_m, 1.0);
  EXPECT_LT((Hue(PixelAt(picture, 2.0, 1.0)) - Hue(HeightColor(0.0))).norm(), 0.03);
}

TEST(DrawBirdsEye, DrawsPathsFromAStartToAnEndMark) {
  const RobotPath path{"robot-1", {{-3, -1, 0.5}, {0, -1, 0.5}, {0, 1.5, 0.5}}};
  const BirdsEyePicture picture = DrawBirdsEye(Room(), {path}, {});
  const Rgb line = PixelAt(picture, -1.5, -1.0);
  EXPECT_EQ(line, PixelAt(picture, 0.0, 0.5));
  EXPECT_GT(Difference(line, PixelAt(picture, -1.5, 0.0)), 100);
  const Rgb start = PixelAt(picture, -3, -1);
  const Rgb end = PixelAt(picture, 0, 1.5);
  EXPECT_GT(start[1], start[0]) << "green";
  EXPECT_GT(end[0], end[1]) << "red";
  EXPECT_GT(Difference(start, line), 100);
  EXPECT_GT(Difference(end, line), 50);
}

TEST(DrawBirdsEye, KeepsEveryPathInView) {
  const RobotPath path{"r", {{-20, 0, 0}, {0, 30, 0}}};
  const BirdsEyePicture picture = DrawBirdsEye(Room(), {path}, {});
  for (const Eigen::Vector3d& position : path.positions_world) {
    const Eigen::Vector2d pixel = picture.view.PixelOf(position.head<2>());
    EXPECT_GT(pixel.x(), 20.0);
    EXPECT_GT(pixel.y(), 80.0);
    EXPECT_LT(pixel.x(), picture.image.width_px() - 150.0);
    EXPECT_LT(pixel.y(), picture.image.height_px() - 60.0);
  }
}

TEST(DrawBirdsEye, SaysSoWhenThereIsNoSurface) {
  const auto ink_near_the_middle = [](const BirdsEyePicture& picture) {
    int count = 0;
    const Eigen::Vector2d middle = picture.view.PixelOf({0, 0});
    for (int v = -20; v < 20; ++v) {
      for (int u = -150; u < 150; ++u) {
        count += picture.image.At(static_cast<int>(middle.x()) + u,
                                  static_cast<int>(middle.y()) + v) == kInk;
      }
    }
    return count;
  };
  const BirdsEyePicture empty = DrawBirdsEye({}, {}, {.title = "nothing"});
  EXPECT_EQ(std::max(empty.image.width_px(), empty.image.height_px()), 1200);
  EXPECT_GT(ink_near_the_middle(empty), 200);
  EXPECT_EQ(ink_near_the_middle(DrawBirdsEye(Room(), {}, {})), 0);
  // Paths alone define the view, even a single point.
  EXPECT_GT(ink_near_the_middle(DrawBirdsEye({}, {{"r", {{-1, -1, 0}, {1, 1, 0}}}}, {})), 100);
  EXPECT_GT(DrawBirdsEye({}, {{"r", {{5, 5, 0}}}}, {}).view.metres_per_px, 0.0);
}

TEST(DrawBirdsEye, IsNotShrunkByAStrayTriangle) {
  Mesh mesh;
  for (int i = 0; i < 4000; ++i) {
    const float x = static_cast<float>(i % 80) * 0.1F;
    const int row = i / 80;
    const float y = static_cast<float>(row) * 0.1F;
    AddFloor({x, y}, {x + 0.1F, y + 0.1F}, 0.0F, &mesh);
  }
  const double metres_per_px = DrawBirdsEye(mesh, {}, {}).view.metres_per_px;
  AddFloor({500, 500}, {500.1F, 500.1F}, 0.0F, &mesh);
  EXPECT_NEAR(DrawBirdsEye(mesh, {}, {}).view.metres_per_px, metres_per_px, 0.1 * metres_per_px);
}

TEST(DrawBirdsEye, SurvivesVerticesThatAreNotFinite) {
  Mesh mesh = Room();
  mesh.vertices_world[0].x() = std::numeric_limits<float>::quiet_NaN();
  mesh.vertices_world[5].z() = std::numeric_limits<float>::infinity();
  const BirdsEyePicture picture = DrawBirdsEye(mesh, {{"r", {{kNan, 0, 0}, {1, 1, 0}}}}, {});
  EXPECT_TRUE(std::isfinite(picture.view.metres_per_px));
}

TEST(DrawBirdsEye, GivesTheSamePictureEachTime) {
  const RobotPath path{"robot-1", {{-3, -1, 0.5}, {0, -1, 0.5}}};
  EXPECT_EQ(DrawBirdsEye(Room(), {path}, {}).image, DrawBirdsEye(Room(), {path}, {}).image);
}

TEST(ChooseCutHeight, FindsNoCeilingInAHallOfBoxesOrUnderATable) {
  EXPECT_FALSE(ChooseCutHeight({}, {}).has_value());
  Mesh mesh = Room();
  EXPECT_FALSE(ChooseCutHeight(mesh, {}).has_value());
  AddCeiling({-2, -1}, {-1, 0}, 0.7F, &mesh);
  EXPECT_FALSE(ChooseCutHeight(mesh, {}).has_value());
}

TEST(ChooseCutHeight, DoesNotCutBelowARobot) {
  Mesh mesh = Room();
  AddCeiling({-4, -2}, {4, 2}, 3.0F, &mesh);
  EXPECT_TRUE(ChooseCutHeight(mesh, {{"car", {{0, 0, 0.5}}}}).has_value());
  EXPECT_FALSE(ChooseCutHeight(mesh, {{"drone", {{0, 0, 3.5}}}}).has_value());
}

/// A cuboid of 1 m x 0.5 m on the floor.
ObjectMark Crate(double x, double y, double yaw_rad, double stationarity) {
  return {{{x, y, 0.5}, {1.0, 0.5, 1.0}, yaw_rad}, stationarity, false};
}

TEST(DrawBirdsEye, ObjectsAreOutlinedInTheColourOfTheirStationarity) {
  const BirdsEyePicture picture =
      DrawBirdsEye(Room(), {}, {Crate(-2.0, -1.0, 0.0, 1.0), Crate(-2.0, 1.0, M_PI / 2, 0.0)}, {});
  const BirdsEyePicture plain = DrawBirdsEye(Room(), {}, {});
  EXPECT_LT(Difference(PixelAt(picture, -1.5, -1.0), StationarityColor(1.0)), 12);
  EXPECT_LT(Difference(PixelAt(picture, -2.0, -0.75), StationarityColor(1.0)), 12);
  EXPECT_LT(Difference(PixelAt(picture, -1.75, 1.0), StationarityColor(0.0)), 12);
  EXPECT_LT(Difference(PixelAt(picture, -2.0, 1.5), StationarityColor(0.0)), 12);
  EXPECT_EQ(PixelAt(picture, -2.0, -1.0), PixelAt(plain, -2.0, -1.0)) << "within the outline";
}

TEST(DrawBirdsEye, AGhostIsABrokenOutlineUnderWhatStandsThere) {
  ObjectMark ghost = Crate(-2.0, -1.0, 0.0, 0.9);
  ghost.is_ghost = true;
  const BirdsEyePicture plain = DrawBirdsEye(Room(), {}, {});
  const auto changed_on_edge = [&plain](const BirdsEyePicture& picture) {
    int changed = 0;
    for (int i = 0; i < 200; ++i) {
      const double x = -2.49 + i * 0.98 / 200;
      changed += PixelAt(picture, x, -0.75) != PixelAt(plain, x, -0.75) ? 1 : 0;
    }
    return changed;
  };
  const int broken = changed_on_edge(DrawBirdsEye(Room(), {}, {ghost}, {}));
  EXPECT_GT(broken, 60);
  EXPECT_LT(broken, 180);
  const BirdsEyePicture both = DrawBirdsEye(Room(), {}, {Crate(-2.0, -1.0, 0.0, 0.9), ghost}, {});
  EXPECT_LT(Difference(PixelAt(both, -2.0, -0.75), StationarityColor(0.9)), 12);
}

TEST(DrawBirdsEye, TheViewHoldsAllObjectsThatAreFinite) {
  ObjectMark nowhere = Crate(kNan, 0.0, 0.0, 0.5);
  const BirdsEyePicture picture =
      DrawBirdsEye(Room(), {}, {Crate(9.0, 7.0, 0.3, 0.5), nowhere}, {});
  const Eigen::Vector2d corner = picture.view.PixelOf({9.4, 7.3});
  EXPECT_GT(corner.y(), 0.0);
  EXPECT_LT(corner.x(), picture.view.width_px);
}

TEST(StationarityColor, DarkensAndCoolsFromGoneToStaying) {
  EXPECT_EQ(StationarityColor(-3.0), StationarityColor(0.0));
  EXPECT_EQ(StationarityColor(7.0), StationarityColor(1.0));
  for (int tenth = 0; tenth < 10; ++tenth) {
    const double share = 0.1 * tenth;
    EXPECT_GE(StationarityColor(share)[0] + 30, StationarityColor(share + 0.1)[0]);
    EXPECT_NE(StationarityColor(share), StationarityColor(share + 0.1));
  }
}

}  // namespace
}  // namespace steadymap

#include "core/association/sample_grid.h"

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_depth.h"

namespace steadymap {
namespace {

/// A frame of a wall, and its samples.
class SampleGridTest : public ::testing::Test {
 protected:
  SampleGridTest() : cloud_(MapConfig()) {
    cloud_.Compute(testing::RenderAnalytic(testing::Plane({0.0, 0.0, 1.0}, 2.0),
                                           testing::AnalyticCamera(),
                                           Eigen::Isometry3d::Identity()));
    samples_.Compute(cloud_);
  }

  /// Returns the place of a point at depth 2 m that projects to cell coordinates (`u`, `v`).
  std::optional<SamplePlace> PlaceAt(double u, double v) const {
    const Eigen::Vector3d point_camera = 2.0 * cloud_.camera().Ray(u, v);
    return samples_.FindPlace(cloud_.camera(), point_camera.cast<float>());
  }

  int cells_wide() const { return samples_.width() * SampleGrid::kStrideCells; }

  int cells_high() const { return samples_.height() * SampleGrid::kStrideCells; }

 private:
  SemanticCloud cloud_;
  SampleGrid samples_;
};

TEST_F(SampleGridTest, FindsThePlaceOfEveryCellOfASample) {
  for (int v = 0; v < cells_high(); ++v) {
    for (int u = 0; u < cells_wide(); ++u) {
      // Tests the cell centre and points just inside its corners.
      for (const double offset : {-0.49, 0.0, 0.49}) {
        const std::optional<SamplePlace> place = PlaceAt(u + offset, v - offset);
        ASSERT_TRUE(place.has_value()) << u << ' ' << v;
        ASSERT_EQ(place->column, u / SampleGrid::kStrideCells);
        ASSERT_EQ(place->row, v / SampleGrid::kStrideCells);
      }
    }
  }
}

TEST_F(SampleGridTest, FindsNoPlaceBesideTheCells) {
  for (const double beyond : {0.51, 2.0, 1e6}) {
    EXPECT_FALSE(PlaceAt(-beyond, 5.0).has_value());
    EXPECT_FALSE(PlaceAt(5.0, -beyond).has_value());
    EXPECT_FALSE(PlaceAt(cells_wide() - 1 + beyond, 5.0).has_value());
    EXPECT_FALSE(PlaceAt(5.0, cells_high() - 1 + beyond).has_value());
  }
}

}  // namespace
}  // namespace steadymap

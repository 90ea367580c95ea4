#include "core/association/sample_grid.h"

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_depth.h"

namespace steadymap {
namespace {

TEST(SampleGrid, FindsThePlaceOfEveryCellOfASample) {
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(testing::RenderAnalytic(testing::Plane({0.0, 0.0, 1.0}, 2.0),
                                        testing::AnalyticCamera(),
                                        Eigen::Isometry3d::Identity()));
  SampleGrid samples;
  samples.Compute(cloud);
  const int cells_wide = samples.width() * SampleGrid::kStrideCells;
  const int cells_high = samples.height() * SampleGrid::kStrideCells;
  for (int v = -2; v < cells_high + 2; ++v) {
    for (int u = -2; u < cells_wide + 2; ++u) {
      // The cell's centre, and points just inside of its corners.
      for (const double offset : {-0.49, 0.0, 0.49}) {
        const Eigen::Vector3d point_camera = 2.0 * cloud.camera().Ray(u + offset, v - offset);
        const std::optional<SamplePlace> place =
            samples.FindPlace(cloud.camera(), point_camera.cast<float>());
        if (u < 0 || v < 0 || u >= cells_wide || v >= cells_high) {
          ASSERT_FALSE(place.has_value()) << u << ' ' << v;
          continue;
        }
        ASSERT_TRUE(place.has_value()) << u << ' ' << v;
        ASSERT_EQ(place->column, u / SampleGrid::kStrideCells);
        ASSERT_EQ(place->row, v / SampleGrid::kStrideCells);
      }
    }
  }
}

}  // namespace
}  // namespace steadymap

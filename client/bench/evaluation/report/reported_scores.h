#pragma once

#include <span>
#include <string_view>

namespace steadymap {

/// What others reported for a method on their own recordings of a route.
struct ReportedScore {
  std::string_view method;
  double precision_percent = 0.0;
  double recall_percent = 0.0;
  double false_positive_percent = 0.0;
};

/// The rows of POCD's table (Qian et al., RSS 2022) for a route: `1-5`,
/// `2-4-4`, `9-2` and `table-top`, which stands for ToyCar; none for other routes. Measured by its
/// authors on real data, on voxels of 20 cm, ToyCar 6 cm: they stand beside ours, never in place of
/// a measurement.
std::span<const ReportedScore> ReportedScoresFor(std::string_view route);

}  // namespace steadymap

#pragma once

#include <span>
#include <string_view>

namespace steadymap {

/// Scores that other authors reported for a method on their own recordings of a route.
struct ReportedScore {
  std::string_view method;
  double precision_percent = 0.0;
  double recall_percent = 0.0;
  double false_positive_percent = 0.0;
};

/// Returns the rows of the table in the POCD paper (Qian et al., RSS 2022) for the routes `1-5`,
/// `2-4-4`, `9-2` and `table-top` (the paper's ToyCar); none for other routes. The authors measured
/// them on real data, on voxels of 20 cm (ToyCar: 6 cm). They are only for comparison and never
/// replace a measurement.
std::span<const ReportedScore> ReportedScoresFor(std::string_view route);

}  // namespace steadymap

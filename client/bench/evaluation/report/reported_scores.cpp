#include "client/bench/evaluation/report/reported_scores.h"

#include <array>

namespace steadymap {
namespace {

using Rows = std::array<ReportedScore, 5>;

constexpr Rows kRoute15 = {{{"Kimera", 60.6, 74.2, 7.7},
                            {"MaskFusion", 54.5, 24.4, 3.5},
                            {"Fehr et al.", 76.3, 76.6, 3.8},
                            {"Panoptic Multi-TSDFs", 77.4, 78.9, 4.2},
                            {"POCD", 80.2, 78.7, 3.0}}};

constexpr Rows kRoute244 = {{{"Kimera", 55.8, 78.3, 8.5},
                             {"MaskFusion", 23.8, 5.5, 3.0},
                             {"Fehr et al.", 67.4, 80.7, 5.3},
                             {"Panoptic Multi-TSDFs", 62.7, 77.1, 5.3},
                             {"POCD", 87.0, 81.2, 1.6}}};

constexpr Rows kRoute92 = {{{"Kimera", 53.6, 76.3, 7.9},
                            {"MaskFusion", 24.8, 6.9, 1.1},
                            {"Fehr et al.", 72.5, 80.3, 3.8},
                            {"Panoptic Multi-TSDFs", 72.2, 83.7, 4.3},
                            {"POCD", 83.0, 78.8, 1.9}}};

constexpr Rows kToyCar = {{{"Kimera", 24.9, 97.4, 13.4},
                           {"MaskFusion", 80.2, 97.8, 1.8},
                           {"Fehr et al.", 62.0, 51.3, 2.0},
                           {"Panoptic Multi-TSDFs", 82.0, 99.2, 1.2},
                           {"POCD", 79.4, 96.9, 1.9}}};

}  // namespace

std::span<const ReportedScore> ReportedScoresFor(std::string_view route) {
  if (route == "1-5") return kRoute15;
  if (route == "2-4-4") return kRoute244;
  if (route == "9-2") return kRoute92;
  if (route == "table-top") return kToyCar;
  return {};
}

}  // namespace steadymap

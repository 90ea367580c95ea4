#include "client/bench/simulator/routes/large_hall.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "client/bench/simulator/scene/counter_random.h"
#include "client/dataset/layouts/torwic_layout.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr double kAisleWidthM = 3.0;
constexpr double kRackDepthM = 1.0;
constexpr double kBayM = 2.7;
constexpr double kRackHeightM = 4.2;
constexpr std::array<double, 3> kShelfHeightsM = {0.15, 1.55, 2.95};
constexpr double kAislePitchM = kAisleWidthM + 2 * kRackDepthM;
constexpr double kHeadroomM = 3.0;  // Between the racks' ends and the walls.
constexpr double kSpeedMPerS = 1.4;

SceneObject& AddRackPart(Scene* scene,
                         const std::string& rack,
                         const Eigen::Vector3d& size_m,
                         const Eigen::Vector3d& base_world) {
  SceneObject& part = AddStandingBox(scene, rack, size_m, {base_world.x(), base_world.y(), 0});
  part.T_world_object.translation().z() += base_world.z();
  part.group = rack;
  part.semantic_class = SceneClass::kRack;
  part.color = {52, 84, 150};
  return part;
}

// One rack along y, from -length / 2 to length / 2, centred at x.
class RackBuilder {
 public:
  RackBuilder(Scene* scene, const LargeHallOptions& options, int rack, double x_m)
      : scene_(scene),
        options_(options),
        name_(absl::StrCat("rack-", rack)),
        key_(Combine(options.seed, static_cast<std::uint64_t>(rack))),
        x_m_(x_m),
        bays_(static_cast<int>(options.aisle_length_m / kBayM)) {}

  void Build() {
    const double start_m = -bays_ * kBayM / 2;
    for (int bay = 0; bay <= bays_; ++bay) {
      AddRackPart(
          scene_, name_, {kRackDepthM, 0.1, kRackHeightM}, {x_m_, start_m + bay * kBayM, 0});
    }
    for (int bay = 0; bay < bays_; ++bay) {
      for (std::size_t level = 0; level < kShelfHeightsM.size(); ++level) {
        const double middle_m = start_m + (bay + 0.5) * kBayM;
        const double height_m = kShelfHeightsM[level];
        AddRackPart(
            scene_, name_, {kRackDepthM, kBayM - 0.1, 0.06}, {x_m_, middle_m, height_m - 0.06});
        AddGoods(middle_m - kBayM / 4, height_m);
        AddGoods(middle_m + kBayM / 4, height_m);
      }
    }
  }

 private:
  void AddGoods(double y_m, double height_m) {
    const std::uint64_t key = Combine(key_, place_++);
    if (UniformOf(key) >= options_.filled_share) return;
    const Eigen::Vector3d size_m(UniformBetween(key, 0, 0.6, 0.95),
                                 UniformBetween(key, 1, 0.6, 1.15),
                                 UniformBetween(key, 2, 0.4, 1.2));
    SceneObject& goods =
        AddStandingBox(scene_, absl::StrCat("goods-", place_), size_m, {x_m_, y_m, 0});
    goods.T_world_object.translation().z() += height_m;
    const auto tone = static_cast<std::uint8_t>(UniformBetween(key, 3, 120, 220));
    goods.color = {tone, static_cast<std::uint8_t>(tone * 3 / 4), 90};
  }

  Scene* scene_;
  const LargeHallOptions& options_;
  std::string name_;
  std::uint64_t key_;
  std::uint64_t place_ = 0;
  double x_m_;
  int bays_;
};

void AddOuterWalls(Scene* scene, const Eigen::Vector2d& size_m) {
  constexpr double kThicknessM = 0.2;
  constexpr double kHeightM = 6.0;
  for (const double side : {-0.5, 0.5}) {
    AddStandingBox(scene, "wall", {size_m.x(), kThicknessM, kHeightM}, {0, side * size_m.y(), 0})
        .semantic_class = SceneClass::kWall;
    AddStandingBox(scene, "wall", {kThicknessM, size_m.y(), kHeightM}, {side * size_m.x(), 0, 0})
        .semantic_class = SceneClass::kWall;
  }
}

double AisleX(const LargeHallOptions& options, int aisle) {
  return (aisle - (options.aisles - 1) / 2.0) * kAislePitchM;
}

// Returns a path up one aisle and down the next.
GroundPath Serpentine(const LargeHallOptions& options) {
  std::vector<Eigen::Vector2d> corners;
  const double end_m = options.aisle_length_m / 2 + kHeadroomM / 2;
  for (int aisle = 0; aisle < options.aisles; ++aisle) {
    const double x_m = AisleX(options, aisle);
    const double first_m = aisle % 2 == 0 ? -end_m : end_m;
    corners.emplace_back(x_m, first_m);
    corners.emplace_back(x_m, -first_m);
  }
  return GroundPath(corners, 1.2, false);
}

absl::Status Check(const LargeHallOptions& options) {
  // Written so that NaN fails.
  const bool fits = options.aisles >= 1 && options.aisles <= 60 && options.aisle_length_m >= 5 &&
                    options.aisle_length_m <= 100 && options.filled_share >= 0 &&
                    options.filled_share <= 1;
  if (fits) return absl::OkStatus();
  return InvalidField(reason::kBadValue,
                      "options",
                      absl::StrCat("expected 1 to 60 aisles of 5 to 100 m and a filled share in "
                                   "[0, 1]; got ",
                                   options.aisles,
                                   " aisles of ",
                                   options.aisle_length_m,
                                   " m, ",
                                   options.filled_share,
                                   " filled"));
}

}  // namespace

absl::StatusOr<Route> MakeLargeHallRoute(const LargeHallOptions& options) {
  if (const absl::Status status = Check(options); !status.ok()) return status;
  Scene scene;
  const Eigen::Vector2d size_m(options.aisles * kAislePitchM + 1.0,
                               options.aisle_length_m + 2 * kHeadroomM);
  AddFloor(&scene, size_m);
  AddOuterWalls(&scene, size_m);
  const double beside_m = (kAisleWidthM + kRackDepthM) / 2;
  for (int aisle = 0; aisle < options.aisles; ++aisle) {
    const double x_m = AisleX(options, aisle);
    RackBuilder(&scene, options, 2 * aisle, x_m - beside_m).Build();
    RackBuilder(&scene, options, 2 * aisle + 1, x_m + beside_m).Build();
  }
  Route route;
  route.name = "hall";
  route.camera = DefaultTorwicCalibration().camera;
  route.sequences.push_back(
      {"hall", std::move(scene), DriveAlong(Serpentine(options), kSpeedMPerS, kTorwicBaseHeightM)});
  return route;
}

}  // namespace steadymap

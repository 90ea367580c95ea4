#include "client/bench/evaluation/room/room_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>

#include "client/bench/simulator/scene/counter_random.h"

namespace steadymap {
namespace {

constexpr RoomLabels kAllLabels[] = {
    RoomLabels::kClasses, RoomLabels::kInstances, RoomLabels::kNone};

constexpr double kVariedShare = 1.0 / 3.0;

constexpr const char* kVoxelNames[] = {"voxel-2cm", "voxel-10cm"};
constexpr const char* kLabelNames[] = {"instances", "no-labels", "no-labels"};
constexpr const char* kPathNames[] = {"pass", "look"};
constexpr const char* kRateNames[] = {"2hz", "15hz", "30hz"};
constexpr const char* kCameraNames[] = {"low", "high", "down"};
constexpr const char* kFloorNames[] = {"floor-1.2m-below", "floor-7m-up", "ramp"};
constexpr const char* kNoiseNames[] = {"noise-0", "noise-1%", "noise-2%"};
constexpr const char* kPoseErrorNames[] = {
    "drift-2cm", "drift-5cm", "drift-8cm", "offset-2cm", "offset-5cm", "offset-8cm"};
constexpr const char* kSensorNames[] = {"hard-sensor"};
constexpr const char* kStopNames[] = {"stops"};

constexpr std::span<const char* const> kAllNames[] = {kVoxelNames,
                                                      kLabelNames,
                                                      kPathNames,
                                                      kRateNames,
                                                      kCameraNames,
                                                      kFloorNames,
                                                      kNoiseNames,
                                                      kPoseErrorNames,
                                                      kSensorNames,
                                                      kStopNames};

constexpr double kRadiansPerDegree = M_PI / 180.0;

// The camera of the room sees less far than its corners.
constexpr double kMaxDepthM = 4.0;

/// Gives one case its variations: those in `given`, or if there are none, drawn ones.
class Variation {
 public:
  Variation(std::uint64_t key, std::span<const std::string> given, RoomCase* room_case)
      : key_(key), given_(given), case_(room_case) {}

  /// Calls `vary(choice)` for the given one of the `names`, or with the probability of a variation
  /// for a drawn one, and notes it.
  template <typename Vary>
  void Maybe(std::span<const char* const> names, const Vary& vary) {
    const std::uint64_t key = Combine(key_, property_++);
    const std::optional<std::size_t> choice =
        given_.empty() ? Draw(key, names.size()) : Find(names);
    if (!choice) return;
    vary(*choice);
    case_->variations.emplace_back(names[*choice]);
  }

  /// Returns a uniform number of the current property.
  double Between(double low, double high) const {
    return UniformBetween(Combine(key_, property_), 2, low, high);
  }

 private:
  static std::optional<std::size_t> Draw(std::uint64_t key, std::size_t count) {
    if (UniformBetween(key, 0, 0.0, 1.0) >= kVariedShare) return std::nullopt;
    return static_cast<std::size_t>(UniformBetween(key, 1, 0.0, static_cast<double>(count)));
  }

  std::optional<std::size_t> Find(std::span<const char* const> names) const {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (std::find(given_.begin(), given_.end(), names[i]) != given_.end()) return i;
    }
    return std::nullopt;
  }

  std::uint64_t key_;
  std::span<const std::string> given_;
  std::uint64_t property_ = 0;
  RoomCase* case_;
};

/// True if two things of one class touch: without instances, they are one thing.
bool AreTouching(RoomChange change) {
  return change == RoomChange::kTouchingRemoved || change == RoomChange::kUpperRemoved ||
         change == RoomChange::kLowerRemoved;
}

void VaryMap(RoomCase* room_case, Variation* variation) {
  // A voxel of 10 cm is as large as the mug.
  const bool is_small = room_case->change == RoomChange::kMugRemoved;
  variation->Maybe(std::span(kVoxelNames).first(is_small ? 1 : 2), [&](std::size_t choice) {
    room_case->voxel_size_m = std::array{0.02, 0.1}[choice];
  });
  if (AreTouching(room_case->change)) return;
  const bool can_be_told = CanBeTold(room_case->change, RoomLabels::kNone);
  variation->Maybe(std::span(kLabelNames).first(can_be_told ? 3 : 1), [&](std::size_t choice) {
    room_case->labels = choice == 0 ? RoomLabels::kInstances : RoomLabels::kNone;
  });
}

void VarySetting(BoxRoomSetting* setting, Variation* variation) {
  variation->Maybe(kPathNames, [&](std::size_t choice) {
    setting->path = std::array{RoomPath::kPass, RoomPath::kLook}[choice];
  });
  variation->Maybe(kRateNames, [&](std::size_t choice) {
    setting->frame_period_s = std::array{1.0 / 2.0, 1.0 / 15.0, 1.0 / 30.0}[choice];
  });
  const double share = variation->Between(0.0, 1.0);
  variation->Maybe(kCameraNames, [&](std::size_t choice) {
    setting->camera_height_m = std::array{0.3, 0.9, 1.5 + 0.5 * share}[choice];
    setting->looks_down = choice == 2;
  });
  variation->Maybe(kFloorNames, [&](std::size_t choice) {
    setting->floor_world_m = std::array{-1.2, 7.0, 0.0}[choice];
    setting->slope_rad = choice == 2 ? 3.0 * kRadiansPerDegree : 0.0;
  });
}

void VarySensor(SensorModel* sensor, Variation* variation) {
  variation->Maybe(kNoiseNames, [&](std::size_t choice) {
    sensor->range_noise_share = std::array{0.0, 0.01, 0.02}[choice];
  });
  variation->Maybe(kPoseErrorNames, [&](std::size_t choice) {
    const double error_m = std::array{0.02, 0.05, 0.08}[choice % 3];
    const double error_rad = std::array{0.5, 0.5, 1.0}[choice % 3] * kRadiansPerDegree;
    const bool is_drift = choice < 3;
    sensor->pose_drift = is_drift;
    (is_drift ? sensor->pose_drift_m : sensor->session_offset_m) = error_m;
    (is_drift ? sensor->pose_drift_rad : sensor->session_offset_rad) = error_rad;
  });
}

/// Gives a sensor the depth and labels of `SensorModel::Hard`.
void VaryKind(SensorModel* sensor, Variation* variation) {
  variation->Maybe(kSensorNames, [&](std::size_t) {
    const SensorModel hard = SensorModel::Hard();
    sensor->correlated_noise = hard.correlated_noise;
    sensor->foreground_fattening = hard.foreground_fattening;
    sensor->label_blobs_a_frame = hard.label_blobs_a_frame;
    sensor->label_flip_share = hard.label_flip_share;
    sensor->unlabelled_share = hard.unlabelled_share;
  });
}

SensorModel DefaultSensor() {
  SensorModel sensor;
  sensor.depth_noise_at_one_metre_m = 0.0;
  sensor.depth_noise_growth_m = 0.0;
  sensor.range_noise_share = 0.005;
  return sensor;
}

}  // namespace

std::string_view NameOf(RoomLabels labels) {
  static constexpr std::string_view kNames[] = {"classes", "instances", "none"};
  return kNames[static_cast<std::size_t>(labels)];
}

std::vector<std::string> RoomLabelNames() {
  std::vector<std::string> names;
  for (const RoomLabels labels : kAllLabels) names.emplace_back(NameOf(labels));
  return names;
}

std::optional<RoomLabels> FindRoomLabels(std::string_view name) {
  for (const RoomLabels labels : kAllLabels) {
    if (NameOf(labels) == name) return labels;
  }
  return std::nullopt;
}

bool CanBeTold(RoomChange change, RoomLabels labels) {
  if (AreTouching(change)) return labels == RoomLabels::kInstances;
  return change != RoomChange::kSwappedClasses || labels != RoomLabels::kNone;
}

void GiveLabels(RoomLabels labels, RoomCase* room_case) {
  std::erase_if(room_case->variations,
                [](const std::string& name) { return name == "instances" || name == "no-labels"; });
  room_case->labels = labels;
}

std::vector<std::string> RoomVariationNames() {
  std::vector<std::string> names;
  for (const std::span<const char* const> property : kAllNames) {
    for (const std::string_view name : property) {
      if (names.empty() || names.back() != name) names.emplace_back(name);
    }
  }
  return names;
}

std::vector<RoomCase> ListRoomCases(RoomChange change,
                                    std::size_t count,
                                    std::uint64_t seed,
                                    std::span<const std::string> variations) {
  std::vector<RoomCase> cases;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t key = Combine(Combine(seed, static_cast<std::uint64_t>(change)), i);
    RoomCase& room_case = cases.emplace_back();
    room_case.change = change;
    room_case.sensor = DefaultSensor();
    if (AreTouching(change)) room_case.labels = RoomLabels::kInstances;
    room_case.seed = Combine(key, 1);
    if (i == 0 && variations.empty()) continue;
    Variation variation(Combine(key, 0), variations, &room_case);
    VaryMap(&room_case, &variation);
    VarySetting(&room_case.setting, &variation);
    VarySensor(&room_case.sensor, &variation);
    VaryKind(&room_case.sensor, &variation);
    variation.Maybe(kStopNames, [&](std::size_t) { room_case.setting.stops = true; });
  }
  // A change may not allow a variation.
  std::erase_if(cases, [&](const RoomCase& room_case) {
    return room_case.variations.size() < variations.size();
  });
  return cases;
}

MapConfig MapConfigFor(const RoomCase& room_case, UpdatePolicy policy) {
  MapConfig config;
  config.policy = policy;
  config.voxel_size_m = room_case.voxel_size_m;
  config.truncation_m = DefaultTruncationM(room_case.voxel_size_m);
  config.max_depth_m = kMaxDepthM;
  return config;
}

}  // namespace steadymap

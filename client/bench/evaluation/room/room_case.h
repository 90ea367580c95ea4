#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/bench/simulator/routes/box_room.h"
#include "client/bench/simulator/sensor/sensor_model.h"
#include "core/types/map_config.h"

namespace steadymap {

/// What the frames say about the things in them.
enum class RoomLabels { kClasses, kInstances, kNone };

/// Returns `classes`, `instances` or `none`.
std::string_view NameOf(RoomLabels labels);

/// Returns the names of all labels.
std::vector<std::string> RoomLabelNames();

/// Returns the labels of that name; none for another text.
std::optional<RoomLabels> FindRoomLabels(std::string_view name);

/// One case: a change, the setting in which it happens, and the errors of what is measured.
struct RoomCase {
  RoomChange change = RoomChange::kNothing;
  BoxRoomSetting setting;
  SensorModel sensor;
  RoomLabels labels = RoomLabels::kClasses;
  double voxel_size_m = 0.05;
  std::uint64_t seed = 1;  ///< Of all noise.
  /// What differs from the default case, such as `voxel-10cm`, `drift-5cm`; empty for that case.
  std::vector<std::string> variations;
};

/// Returns `count` cases of a change: first the default case, then ones in which each property
/// (voxel, frame rate, path, height of the camera, floor, labels, noise, pose error, stops) has
/// another value with a probability of a third. With `variations`, every case has these and no
/// others; there are no cases if the change does not allow them. Equal arguments give equal cases.
std::vector<RoomCase> ListRoomCases(RoomChange change,
                                    std::size_t count,
                                    std::uint64_t seed,
                                    std::span<const std::string> variations = {});

/// Returns the names of all variations.
std::vector<std::string> RoomVariationNames();

/// True if cases of a change have a truth with these labels: things that touch are two only by
/// their instances, and classes that change places cannot be seen without labels.
bool CanBeTold(RoomChange change, RoomLabels labels);

/// Gives a case these labels instead of those that were drawn.
void GiveLabels(RoomLabels labels, RoomCase* room_case);

/// Returns the configuration of the case's map.
MapConfig MapConfigFor(const RoomCase& room_case, UpdatePolicy policy);

}  // namespace steadymap

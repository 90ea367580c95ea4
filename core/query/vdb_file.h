#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"
#include "core/map/map_snapshot.h"
#include "core/map/placed_volume.h"
#include "core/query/file_encoder.h"
#include "core/types/cancellation.h"

namespace steadymap {

/// Volumes of a map as an OpenVDB 10 file. Each has two stock float grids, `<name>/distance` and
/// `<name>/weight`, and where colour was recorded `<name>/color` (Vec3f, 0 to 1); its name is
/// `background` or `object-<id>`. A grid's transform takes voxel indices to the world, metres.
///
/// Metadata of every grid: `object_id` (0 for the background), `class_id`, `revision`,
/// `voxel_size_m`, `truncation_m`; of an object's also `standing`, `stationarity`, `alpha`, `beta`,
/// `change_mean_m`, `change_std_m`, `first_seen_s`, `last_seen_s` (seconds since 1970), `views`,
/// `absences`. Equal volumes give equal bytes.
///
/// The file is laid out as a stream: grid after grid, without places to seek to. `box_world`, where
/// given, keeps the voxels whose centre lies within it.
///
/// No volume may come twice. The snapshot and what the volumes point to must outlive the encoder.
/// Memory: 140 bytes for each leaf of one volume, and the piece. Cost: about 20 us a leaf.
/// Errors of `Next`: `Cancelled` as `cancellation` says; `Internal` where OpenVDB fails.
std::unique_ptr<FileEncoder> MakeVdbEncoder(const MapSnapshot& snapshot,
                                            std::vector<PlacedVolume> volumes,
                                            const std::optional<Box>& box_world,
                                            Cancellation cancellation = {});

/// The whole of such a file. Errors: as the encoder's.
absl::StatusOr<std::string> WriteVdb(const MapSnapshot& snapshot,
                                     std::span<const PlacedVolume> volumes,
                                     const Box* box_world);

/// All that a map shows, as such a file.
absl::StatusOr<std::string> WriteVdb(const MapSnapshot& snapshot, const Box* box_world);

}  // namespace steadymap

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

/// Returns the encoder of an OpenVDB 10 file with volumes of a map. Each volume has two stock float
/// grids, `<name>/distance` and `<name>/weight`, and if colour was recorded `<name>/color` (Vec3f,
/// 0 to 1). The name is `background` or `object-<id>`. The transform of a grid maps voxel indices
/// to the world frame, metres.
///
/// Metadata of every grid: `object_id` (0 for the background), `class_id`, `revision`,
/// `voxel_size_m`, `truncation_m`; grids of an object also have `standing`, `stationarity`,
/// `alpha`, `beta`, `change_mean_m`, `change_std_m`, `first_seen_s`, `last_seen_s` (seconds since
/// 1970), `views`, `absences`. Equal volumes give equal bytes.
///
/// The file has the stream layout: grids in sequence, without offsets. `box_world`, if set, selects
/// the voxels with their centre in the box.
///
/// `volumes` must not contain duplicates. The snapshot and the data referenced by `volumes` must
/// outlive the encoder. Memory: 140 bytes per leaf of the current volume, and the piece. Cost:
/// about 20 us per leaf. Errors of `Next`: `Cancelled` after cancellation; `Internal` if OpenVDB
/// fails.
std::unique_ptr<FileEncoder> MakeVdbEncoder(const MapSnapshot& snapshot,
                                            std::vector<PlacedVolume> volumes,
                                            const std::optional<Box>& box_world,
                                            Cancellation cancellation = {});

/// Returns the whole OpenVDB file of `volumes`. Errors: of `MakeVdbEncoder`.
absl::StatusOr<std::string> WriteVdb(const MapSnapshot& snapshot,
                                     std::span<const PlacedVolume> volumes,
                                     const Box* box_world);

/// Returns the whole OpenVDB file of the background and all present objects. Errors: of
/// `MakeVdbEncoder`.
absl::StatusOr<std::string> WriteVdb(const MapSnapshot& snapshot, const Box* box_world);

}  // namespace steadymap

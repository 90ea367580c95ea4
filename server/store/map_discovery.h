#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include <absl/status/statusor.h>

#include "core/types/identifiers.h"
#include "server/store/disk/mirrored_file.h"
#include "server/store/map/map_folder.h"
#include "server/store/model/store.h"

namespace steadymap {

/// The folder in the data folder that holds a folder for each map.
inline constexpr char kMapsFolderName[] = "maps";

/// Suffix of a map's folder until the map is complete.
inline constexpr char kUnfinishedSuffix[] = ".new";

/// The maps of a data folder.
struct DiscoveredMaps {
  /// By key. The `condition` of a record says why its map cannot be used.
  std::map<MapKey, MapRecord> records{};
  std::vector<MapKey> deleted{};  ///< Their folders are still there.
  MapKey next_key{1};             ///< Greater than every key that is or was in use.
};

/// The folder of the map `key` in the data folder `folder`.
MapFolder MapFolderOf(const std::filesystem::path& folder, MapKey key);

/// Finds the maps of the data folder `folder`: those that the catalog names, and those whose
/// folders exist although no catalog names them, as after its loss. A damaged catalog or record is
/// no error. Removes folders of maps whose creation a crash interrupted, and gives copies of a
/// map's folder an incarnation of their own. Errors: `DataLoss` for a catalog that cannot be
/// understood; those of the file system.
absl::StatusOr<DiscoveredMaps> DiscoverMaps(const std::filesystem::path& folder,
                                            const MirroredFile& catalog_file);

}  // namespace steadymap

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

/// The name of the folder that contains the folders of the maps, inside the data folder.
inline constexpr char kMapsFolderName[] = "maps";

/// Suffix of the folder of a map whose creation is not complete.
inline constexpr char kUnfinishedSuffix[] = ".new";

/// The maps found in a data folder.
struct DiscoveredMaps {
  /// By key. The `condition` of a record reports why its map cannot be used.
  std::map<MapKey, MapRecord> records{};
  std::vector<MapKey> deleted{};  ///< Deleted maps whose folders still exist.
  MapKey next_key{1};             ///< Greater than every key that is or was used.
};

/// Returns the folder of the map `key` in the data folder `folder`.
MapFolder MapFolderOf(const std::filesystem::path& folder, MapKey key);

/// Finds the maps of the data folder `folder`: all maps listed in the catalog, and all maps with a
/// folder that the catalog does not list, for example after the loss of the catalog. A damaged
/// catalog file or record is not an error. Removes folders of maps whose creation was interrupted
/// by a crash, and gives a copied map folder a new incarnation. Errors: `DataLoss` for a catalog
/// whose content cannot be parsed; those of the file system.
absl::StatusOr<DiscoveredMaps> DiscoverMaps(const std::filesystem::path& folder,
                                            const MirroredFile& catalog_file);

}  // namespace steadymap

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// The keys and names of the maps of a store, and the next unused key. It preserves the name of a
/// map whose folder is damaged or missing.
struct StoreCatalog {
  struct Map {
    MapKey key;
    MapName name;
  };

  MapKey next_key{1};
  std::vector<Map> maps{};

  /// Converts the catalog to bytes. `Unpack` converts back. Error of `Unpack`: `DataLoss`.
  std::string Pack() const;
  static absl::StatusOr<StoreCatalog> Unpack(std::string_view bytes);
};

}  // namespace steadymap

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// Which maps a store has, by key, so that one whose folder is damaged or gone keeps its name, and
/// the next key to give away.
struct StoreCatalog {
  struct Map {
    MapKey key;
    MapName name;
  };

  MapKey next_key{1};
  std::vector<Map> maps{};

  /// As bytes, and back. Errors of the latter: `DataLoss`.
  std::string Pack() const;
  static absl::StatusOr<StoreCatalog> Unpack(std::string_view bytes);
};

}  // namespace steadymap

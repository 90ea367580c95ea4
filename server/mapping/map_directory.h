#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>

#include "core/types/identifiers.h"
#include "server/mapping/map_runtime.h"
#include "server/store/model/store.h"

namespace steadymap {

/// Returns the error for a map that does not exist.
absl::Status MapNotFound(const MapName& name, std::string_view field);

/// All maps of the server, by name. Creation, update and deletion of a map write to disk.
/// Thread-safe.
class MapDirectory {
 public:
  /// `dependencies` are passed to every map.
  explicit MapDirectory(MapRuntime::Dependencies dependencies);

  /// Finds all maps of the store and starts to open them. Errors: those of `Store::ListMaps`.
  absl::Status Load() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the map `name`, in any condition. Errors: `NotFound`, with `field`.
  absl::StatusOr<std::shared_ptr<MapRuntime>> Get(const MapName& name, std::string_view field) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Parses `name`, from the request field `field`, and returns the map, in any condition. Errors:
  /// `InvalidArgument` with reason `BAD_NAME`; `NotFound`.
  absl::StatusOr<std::shared_ptr<MapRuntime>> Find(const std::string& name,
                                                   std::string_view field) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns at most `limit` maps of a tenant with ids greater than `after`, sorted by id.
  std::vector<std::shared_ptr<MapRuntime>> List(const std::string& tenant,
                                                const std::string& after,
                                                std::size_t limit) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns all maps.
  std::vector<std::shared_ptr<MapRuntime>> All() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Creates a map and starts to open it. Errors: `AlreadyExists`, `ResourceExhausted` with reason
  /// `MEMORY_LOW`, or those of the store.
  absl::StatusOr<std::shared_ptr<MapRuntime>> Create(const MapRecord& record)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Replaces the record of a map. Errors: those of the store.
  absl::Status Update(MapRuntime& map, const MapRecord& record);

  /// Deletes a map. The deletion is durable when this call returns; calls in progress for the map
  /// end soon after. Calls `end_streams` after the map was removed from the directory. Errors:
  /// those of the store; the map is then unchanged.
  absl::Status Delete(const std::shared_ptr<MapRuntime>& map,
                      const std::function<void(const absl::Status&)>& end_streams)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Closes all maps after a last commit and waits until they are closed. No function may be called
  /// afterwards.
  void Close(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  const MapRuntime::Dependencies dependencies_;
  mutable absl::Mutex mutex_;
  std::map<MapName, std::shared_ptr<MapRuntime>> maps_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap

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

/// The error for a map that does not exist.
absl::Status MapNotFound(const MapName& name, std::string_view field);

/// All maps of the server, by name. Thread-safe. What creates, changes or deletes a map writes to
/// disk.
class MapDirectory {
 public:
  /// `dependencies` are what every map gets.
  explicit MapDirectory(MapRuntime::Dependencies dependencies);

  /// Finds all maps of the store and begins to open them. Errors: what the store's list ends with.
  absl::Status Load() ABSL_LOCKS_EXCLUDED(mutex_);

  /// The map `name`, whatever its condition. Errors: `NotFound`, with `field`.
  absl::StatusOr<std::shared_ptr<MapRuntime>> Get(const MapName& name, std::string_view field) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// The map that a request calls `name` in its field `field`, whatever its condition. Errors:
  /// `InvalidArgument` with reason `BAD_NAME`; `NotFound`.
  absl::StatusOr<std::shared_ptr<MapRuntime>> Find(const std::string& name,
                                                   std::string_view field) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// At most `limit` maps of a tenant whose ids follow `after`, in their order.
  std::vector<std::shared_ptr<MapRuntime>> List(const std::string& tenant,
                                                const std::string& after,
                                                std::size_t limit) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Every map.
  std::vector<std::shared_ptr<MapRuntime>> All() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Creates a map and begins to open it. Errors: `AlreadyExists`, `ResourceExhausted` with
  /// `MEMORY_LOW`, or what the store answers.
  absl::StatusOr<std::shared_ptr<MapRuntime>> Create(const MapRecord& record)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Replaces the record of a map. Errors: what the store answers.
  absl::Status Update(MapRuntime& map, const MapRecord& record);

  /// Deletes a map, for good once this returns; what is under way for it ends soon after.
  /// `end_streams` is called once nobody finds the map any more. Errors: what the store answers;
  /// the map is then as it was.
  absl::Status Delete(const std::shared_ptr<MapRuntime>& map,
                      const std::function<void(const absl::Status&)>& end_streams)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Closes all maps after a last commit, and waits for that; nothing may be looked up afterwards.
  void Close(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  const MapRuntime::Dependencies dependencies_;
  mutable absl::Mutex mutex_;
  std::map<MapName, std::shared_ptr<MapRuntime>> maps_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap

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

#include "core/identifiers.h"
#include "server/map_runtime.h"
#include "server/store.h"

namespace steadymap {

/// The error for a map that does not exist.
absl::Status MapNotFound(const MapName& name, std::string_view field);

/// All maps of the server, by name. Looking up is for any thread; `Create`, `Update` and `Delete`
/// write to disk and are for one thread at a time.
class MapDirectory {
 public:
  /// `surroundings` is what every map gets.
  explicit MapDirectory(MapRuntime::Surroundings surroundings);

  /// Loads all maps of the store. Maps that cannot be loaded are there, in quarantine.
  /// Errors: what the store's list ends with.
  absl::Status Load() ABSL_LOCKS_EXCLUDED(mutex_);

  /// The map `name`, usable or in quarantine. Errors: `NotFound`, with `field`.
  absl::StatusOr<std::shared_ptr<MapRuntime>> Get(const MapName& name, std::string_view field) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// The usable map that a request calls `name` in its field `field`. Errors: `InvalidArgument`
  /// with reason `BAD_NAME`; `NotFound`; the condition of a map in quarantine.
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

  /// Creates a map. Errors: `AlreadyExists`, or what the store answers.
  absl::StatusOr<std::shared_ptr<MapRuntime>> Create(const MapRecord& record)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Replaces the record of a map. Errors: what the store answers.
  absl::Status Update(MapRuntime& map, const MapRecord& record);

  /// Deletes a map. `end_streams` is called once nobody finds the map any more.
  /// Errors: what the store answers; the map is then closed all the same.
  absl::Status Delete(const std::shared_ptr<MapRuntime>& map,
                      const std::function<void(const absl::Status&)>& end_streams)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Closes all maps after a last commit; nothing may be looked up afterwards.
  void Close(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  const MapRuntime::Surroundings surroundings_;
  mutable absl::Mutex mutex_;
  std::map<MapName, std::shared_ptr<MapRuntime>> maps_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap

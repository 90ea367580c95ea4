#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"
#include "core/integration/semantic_cloud.h"
#include "core/map/map_snapshot.h"
#include "core/policy/map_updater.h"
#include "core/policy/mapper_options.h"
#include "core/policy/stage_observer.h"
#include "core/types/identifiers.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"

namespace steadymap {

/// Builds one map from the entries of its log. A function of the entries alone: the same ones in
/// the same order give the same map, bit for bit, wherever commits and restarts fall.
///
/// One thread at a time. Snapshots that it handed out are never touched again.
class Mapper {
 public:
  /// Errors: as `ValidateMapConfig`.
  static absl::StatusOr<std::unique_ptr<Mapper>> Create(const MapConfig& config,
                                                        const MapperOptions& options = {});

  /// Continues from a stored map instead of an empty one. Call before the first `Integrate`.
  /// `snapshot.scale` must be the configuration's (asserted).
  void Restore(const MapSnapshot& snapshot);

  /// Takes in the frame with sequence number `sequence`, the one after `head()` (asserted). The
  /// frame must have passed `ValidateFrame` (asserted).
  void Integrate(MapSequence sequence, const Frame& frame);

  /// Adds classes to the map's table: the entry with sequence number `sequence`, as above. Together
  /// with the table they must be a valid one (asserted).
  void AddClasses(MapSequence sequence, const std::vector<SemanticClass>& classes);

  /// Passes over an entry that is not to be integrated.
  void Skip(MapSequence sequence);

  /// Gives back the memory that is only needed while frames come, some megabytes; the next one
  /// takes it again. Changes nothing else.
  void Rest();

  /// The newest entry taken in, committed or not.
  MapSequence head() const { return MapSequence(map_.revision().value()); }

  /// Bytes that the mapper keeps of the surfaces of objects, beside what snapshots hold.
  std::size_t surface_bytes() const { return map_.surface_bytes(); }

  /// Entries taken in since the last commit.
  std::size_t uncommitted_entries() const { return uncommitted_entries_; }

  /// Closes the work since the last commit. With no entry since then: an empty delta.
  MapCommit Commit();

 private:
  Mapper(const MapConfig& config, const MapperOptions& options);

  void UseClasses();
  void PrepareForFrames();

  const std::vector<SemanticClass> created_classes_;  ///< Of the configuration.
  MapConfig config_;                                  ///< With the classes that were added.
  const MapperOptions options_;
  StageTimer stages_;
  std::unique_ptr<SemanticCloud> cloud_;  ///< Of the frame at hand; null while the mapper rests.
  std::unique_ptr<MapUpdater> updater_;   ///< Likewise.
  WorkingMap map_;                        ///< Ahead of the last commit.
  std::size_t uncommitted_entries_ = 0;
};

}  // namespace steadymap

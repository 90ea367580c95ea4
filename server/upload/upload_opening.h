#pragma once

#include "server/config/server_config.h"
#include "server/mapping/map_runtime.h"
#include "server/store/model/store.h"

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {

/// Makes the response to the `open` message of an upload stream, without its credit.
/// `known_durable` is the last frame acknowledged as durable, as reported by the client. If the map
/// does not contain it, for example after a restore from a backup, the response and the log name
/// the lost frames. The map must be open.
v1::UploadFramesResponse MakeOpenedResponse(MapRuntime* map,
                                            const SessionName& session,
                                            ClientSequence known_durable,
                                            const LimitOptions& limits);

/// Logs a warning, once per upload, if frames without labels arrive at a map that keeps objects.
/// Not thread-safe.
class MissingLabelsWarning {
 public:
  /// Enables the warning if the map keeps objects.
  void SetNeedsLabels(bool needs_labels) { is_pending_ = needs_labels; }

  /// Logs the warning if `batch` is the first with a frame that has neither labels nor instances.
  void Check(const v1::FrameBatch& batch, const MapName& map, const SessionName& session);

 private:
  bool is_pending_ = false;
};

}  // namespace steadymap

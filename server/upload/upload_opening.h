#pragma once

#include "server/config/server_config.h"
#include "server/mapping/map_runtime.h"
#include "server/store/model/store.h"

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {

/// The server's answer to the `open` of an upload stream, its credit aside. `known_durable` is the
/// last frame that the client knows to be durable: if the map has come less far, as after a restore
/// from a backup, the answer names the frames that are lost, and the log does, too. The map must be
/// open.
v1::UploadFramesResponse MakeOpenedResponse(MapRuntime* map,
                                            const SessionName& session,
                                            ClientSequence known_durable,
                                            const LimitOptions& limits);

/// Logs once per upload that frames without labels reach a map that keeps objects. One thread at a
/// time.
class MissingLabelsWarning {
 public:
  /// Sets whether there is anything to warn of: whether the map keeps objects.
  void SetKeepsObjects(bool keeps_objects) { is_pending_ = keeps_objects; }

  /// Warns if `batch` is the first with a frame that has neither labels nor instances.
  void Check(const v1::FrameBatch& batch, const MapName& map, const SessionName& session);

 private:
  bool is_pending_ = false;
};

}  // namespace steadymap

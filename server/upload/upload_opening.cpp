#include "server/upload/upload_opening.h"

#include <algorithm>
#include <cstdint>

#include <spdlog/spdlog.h>

#include "core/frame/frame.h"

namespace steadymap {

v1::UploadFramesResponse MakeOpenedResponse(MapRuntime* map,
                                            const SessionName& session,
                                            ClientSequence known_durable,
                                            const LimitOptions& limits) {
  const SessionState state = map->sessions().State(session, map->snapshot()->integrated());
  spdlog::debug("map {} sensor {} session {}: upload opened, durable up to client sequence {}",
                map->name().ToString(),
                session.sensor.ToString(),
                session.session,
                state.durable.value());
  v1::UploadFramesResponse response;
  v1::UploadOpened* opened = response.mutable_opened();
  opened->set_resume_client_seq(state.durable.value());
  opened->set_max_message_bytes(limits.max_message_bytes);
  opened->set_max_image_side_px(static_cast<std::uint32_t>(kMaxImageSidePx));
  if (known_durable <= state.durable || !map->CheckReads().ok()) return response;
  opened->mutable_lost()->set_first(state.durable.value() + 1);
  opened->mutable_lost()->set_last(known_durable.value());
  spdlog::warn(
      "map {} sensor {} session {}: frames {} to {} were acknowledged as durable but are missing; "
      "check whether the store was restored from an older copy",
      map->name().ToString(),
      session.sensor.ToString(),
      session.session,
      state.durable.value() + 1,
      known_durable.value());
  return response;
}

void MissingLabelsWarning::Check(const v1::FrameBatch& batch,
                                 const MapName& map,
                                 const SessionName& session) {
  if (!is_pending_) return;
  const auto frame = std::find_if(batch.frames().begin(), batch.frames().end(), [](const auto& f) {
    return !f.has_labels() && !f.has_instances();
  });
  if (frame == batch.frames().end()) return;
  is_pending_ = false;
  spdlog::warn(
      "map {} sensor {} session {}: frames have neither labels nor instances, so the map gets no "
      "objects from them",
      map.ToString(),
      session.sensor.ToString(),
      session.session);
}

}  // namespace steadymap

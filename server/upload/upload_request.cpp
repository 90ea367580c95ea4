#include "server/upload/upload_request.h"

#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "server/upload/batch_intake.h"

namespace steadymap {
namespace {

absl::Status CheckId(const char* field, const std::string& id) {
  if (IsValidId(id)) return absl::OkStatus();
  // The id is truncated, because it may be megabytes of arbitrary data.
  return InvalidField(
      reason::kBadName,
      field,
      absl::StrCat(field, " must match [a-z][a-z0-9-]{0,62}, got \"", id.substr(0, 100), "\""));
}

}  // namespace

absl::StatusOr<UploadTarget> FindUploadTarget(const MapDirectory& maps,
                                              const std::string& map,
                                              const std::string& robot,
                                              const std::string& sensor,
                                              const std::string& session) {
  if (absl::Status status = CheckId("robot", robot); !status.ok()) return status;
  const std::string named_sensor = sensor.empty() ? SensorName::kDefaultSensor : sensor;
  if (absl::Status status = CheckId("sensor", named_sensor); !status.ok()) return status;
  if (absl::Status status = CheckId("session", session); !status.ok()) return status;
  absl::StatusOr<std::shared_ptr<MapRuntime>> found = maps.Find(map, "map");
  if (!found.ok()) return found.status();
  return UploadTarget{*std::move(found), SessionName{{robot, named_sensor}, session}};
}

RequestLimits UploadRequestLimits(const LimitOptions& limits) {
  // Enough for a frame with four images and for fields of later versions.
  constexpr std::size_t kFieldsPerFrame = 64;
  return {limits.max_message_bytes, (kMaxBatchFrames + 1) * kFieldsPerFrame};
}

}  // namespace steadymap

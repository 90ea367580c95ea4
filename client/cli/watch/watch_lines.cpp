#include "client/cli/watch/watch_lines.h"

#include <sstream>

#include <absl/strings/str_cat.h>

#include "client/cli/text/json_writer.h"
#include "client/cli/text/number_text.h"
#include "client/cli/watch/resume_token.h"

namespace steadymap {
namespace {

JsonWriter BeginLine(std::string_view kind) {
  JsonWriter json(JsonLayout::kOneLine);
  json.BeginObject().Key("kind").Text(kind);
  return json;
}

std::string FinishLine(JsonWriter* json) {
  json->EndObject();
  return json->Finish();
}

std::string VolumeJson(const WatchStep& step, const VolumeChange& change) {
  JsonWriter json = BeginLine("volume");
  json.Key("revision").Integer(step.revision.value());
  json.Key("previous_revision").Integer(step.previous_revision.value());
  json.Key("commits").Integer(step.commits);
  json.Key("last_capture_time").Number(step.last_capture_time.value_or(Timestamp()).seconds());
  json.Key("leaves").BeginArray();
  for (const auto& [object, counts] : change) {
    json.BeginObject().Key("object").Integer(object);
    json.Key("changed").Integer(counts.changed).Key("gone").Integer(counts.gone).EndObject();
  }
  json.EndArray();
  return FinishLine(&json);
}

}  // namespace

std::string WatchLines::Created(const v1::WatchCreated& created) const {
  if (!as_json_) {
    return absl::StrCat("created   revision ",
                        created.revision(),
                        ", voxels of ",
                        LengthText(created.voxel_size_m()),
                        "\n");
  }
  JsonWriter json = BeginLine("created");
  json.Key("revision").Integer(created.revision());
  json.Key("voxel_size_m").Number(created.voxel_size_m());
  json.Key("truncation_m").Number(created.truncation_m());
  json.Key("incarnation").Text(created.incarnation());
  return FinishLine(&json);
}

std::string WatchLines::Event(const v1::ObjectEvent& event) const {
  if (!as_json_) {
    std::ostringstream line;
    WriteEventLines({event}, classes_, &line);
    return "event  " + line.str();
  }
  JsonWriter json = BeginLine("event");
  json.Key("event");
  WriteEventJson(event, classes_, &json);
  return FinishLine(&json);
}

std::string WatchLines::Object(Revision revision, const v1::Object& object) const {
  if (!as_json_) return absl::StrCat("object    ", ObjectText(object, classes_), "\n");
  JsonWriter json = BeginLine("object");
  json.Key("revision").Integer(revision.value());
  json.Key("object");
  WriteObjectJson(object, classes_, &json);
  return FinishLine(&json);
}

std::string WatchLines::Removed(Revision revision, std::uint64_t object) const {
  if (!as_json_) return absl::StrCat("removed   object ", object, " is no longer shown\n");
  JsonWriter json = BeginLine("removed");
  json.Key("revision").Integer(revision.value()).Key("object").Integer(object);
  return FinishLine(&json);
}

std::string WatchLines::Volume(const WatchStep& step, const VolumeChange& change) const {
  if (as_json_) return VolumeJson(step, change);
  std::uint64_t background = 0;
  std::uint64_t of_objects = 0;
  std::uint64_t objects = 0;
  for (const auto& [object, counts] : change) {
    const std::uint64_t leaves = counts.changed + counts.gone;
    (object == 0 ? background : of_objects) += leaves;
    if (object != 0) ++objects;
  }
  return absl::StrCat("volume    ",
                      CountText(background),
                      " leaves of the background, ",
                      CountText(of_objects),
                      " of ",
                      CountText(objects),
                      " objects\n");
}

std::string WatchLines::Resync(Revision revision, std::string_view reason) const {
  if (!as_json_) {
    return absl::StrCat("resync    all earlier content is invalid; restarted at revision ",
                        revision.value(),
                        " (",
                        std::string(reason),
                        ")\n");
  }
  JsonWriter json = BeginLine("resync");
  json.Key("revision").Integer(revision.value()).Key("reason").Text(reason);
  return FinishLine(&json);
}

std::string WatchLines::Progress(const WatchStep& step) const {
  const std::string token = ResumeTokenText(step.resume_token);
  if (!as_json_) {
    return absl::StrCat("progress  revision ", step.revision.value(), ", token ", token, "\n");
  }
  JsonWriter json = BeginLine("progress");
  json.Key("revision").Integer(step.revision.value());
  json.Key("previous_revision").Integer(step.previous_revision.value());
  json.Key("commits").Integer(step.commits);
  json.Key("snapshot").Boolean(step.is_snapshot);
  json.Key("resume_token").Text(token);
  return FinishLine(&json);
}

}  // namespace steadymap

#include "client/cli/watch/watch_lines.h"

#include <sstream>
#include <utility>

#include <absl/strings/str_cat.h>

#include "client/cli/text/json_text.h"
#include "client/cli/text/number_text.h"
#include "client/cli/watch/resume_token.h"

namespace steadymap {
namespace {

Json VolumeJson(const WatchStep& step, const VolumeChange& change) {
  Json leaves = Json::array();
  for (const auto& [object, counts] : change) {
    leaves.push_back({{"object", object}, {"changed", counts.changed}, {"gone", counts.gone}});
  }
  return {{"kind", "volume"},
          {"revision", step.revision.value()},
          {"previous_revision", step.previous_revision.value()},
          {"commits", step.commits},
          {"last_capture_time", step.last_capture_time.value_or(Timestamp()).seconds()},
          {"leaves", std::move(leaves)}};
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
  return JsonLine({{"kind", "created"},
                   {"revision", created.revision()},
                   {"voxel_size_m", created.voxel_size_m()},
                   {"truncation_m", created.truncation_m()},
                   {"incarnation", created.incarnation()}});
}

std::string WatchLines::Event(const v1::ObjectEvent& event) const {
  if (!as_json_) {
    std::ostringstream line;
    WriteEventLines({event}, classes_, &line);
    return "event  " + line.str();
  }
  return JsonLine({{"kind", "event"}, {"event", EventJson(event, classes_)}});
}

std::string WatchLines::Object(Revision revision, const v1::Object& object) const {
  if (!as_json_) return absl::StrCat("object    ", ObjectText(object, classes_), "\n");
  return JsonLine({{"kind", "object"},
                   {"revision", revision.value()},
                   {"object", ObjectJson(object, classes_)}});
}

std::string WatchLines::Removed(Revision revision, std::uint64_t object) const {
  if (!as_json_) return absl::StrCat("removed   object ", object, " is no longer shown\n");
  return JsonLine({{"kind", "removed"}, {"revision", revision.value()}, {"object", object}});
}

std::string WatchLines::Volume(const WatchStep& step, const VolumeChange& change) const {
  if (as_json_) return JsonLine(VolumeJson(step, change));
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
  return JsonLine({{"kind", "resync"}, {"revision", revision.value()}, {"reason", reason}});
}

std::string WatchLines::Progress(const WatchStep& step) const {
  const std::string token = ResumeTokenText(step.resume_token);
  if (!as_json_) {
    return absl::StrCat("progress  revision ", step.revision.value(), ", token ", token, "\n");
  }
  return JsonLine({{"kind", "progress"},
                   {"revision", step.revision.value()},
                   {"previous_revision", step.previous_revision.value()},
                   {"commits", step.commits},
                   {"snapshot", step.is_snapshot},
                   {"resume_token", token}});
}

}  // namespace steadymap

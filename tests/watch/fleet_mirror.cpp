#include "tests/watch/fleet_mirror.h"

#include <chrono>
#include <utility>

#include <absl/strings/str_cat.h>

#include "client/transport/channel.h"
#include "proto/convert_event.h"
#include "proto/convert_object.h"
#include "tests/server/store/store_builder.h"

namespace steadymap {
namespace {

constexpr std::chrono::milliseconds kRetryDelay{20};

/// Returns a filter: everything, half of the view, goods with archived ones, or the background and
/// two objects.
MapFilter DrawMirrorFilter(std::uint32_t seed) {
  MapFilter filter;
  switch (seed % 4) {
    case 1:
      filter.boxes_world = {Box(Eigen::Vector3d(0.0, 0.0, -2.0), Eigen::Vector3d(3.0, 3.0, 2.0))};
      break;
    case 2:
      filter.classes = {ClassId(7)};
      filter.archived = true;
      break;
    case 3:
      filter.objects = {kBackgroundId, ObjectId(1), ObjectId(2)};
      break;
    default:
      break;
  }
  return filter;
}

WatchedContent ContentOf(const MapSnapshot& map) {
  WatchedContent content;
  for (const LeafChange& leaf : LeavesOf(map)) content.leaves[leaf.key] = leaf.packed;
  for (const auto& [id, object] : map.objects) {
    content.objects[id] = ToProto(*object).SerializeAsString();
  }
  return content;
}

}  // namespace

FleetMirror::FleetMirror(const FleetServer* server, std::uint32_t seed)
    : server_(server),
      filter_(DrawMirrorFilter(seed)),
      proxy_(server->address()),
      replay_(&server->history(), server->scale()) {
  MirrorOptions options;
  options.filter = filter_;
  options.seed = seed + 1;
  options.max_message_bytes = 65'536;  // So that steps take several messages.
  options.backoff.first_delay = kRetryDelay;
  options.backoff.max_delay = kRetryDelay;
  MirrorCallbacks callbacks;
  callbacks.on_step = [this](const MirrorStep& step) {
    const absl::MutexLock lock(&mutex_);
    Check(step);
  };
  callbacks.on_state = [this](const WatchStateChange& change) {
    const absl::MutexLock lock(&mutex_);
    life_.reconnections += change.state == WatchState::kReconnecting ? 1 : 0;
  };
  mirror_ = MapMirror::Start(
      ChannelsTo(proxy_.address()), MapName::Parse(server->map()).value(), options, callbacks);
}

MirrorLife FleetMirror::Stop() {
  const absl::Status status = mirror_->status();
  mirror_.reset();
  const absl::MutexLock lock(&mutex_);
  if (!status.ok()) life_.broken.push_back("the mirror ended with " + status.ToString());
  return std::move(life_);
}

void FleetMirror::Check(const MirrorStep& step) {
  ++life_.steps;
  life_.snapshots += step.is_snapshot ? 1 : 0;
  const Revision revision = step.map->revision;
  if (revision < replay_.revision() || !replay_.GoTo(revision)) {
    life_.broken.push_back(absl::StrCat("there was no revision ", revision.value()));
    return;
  }
  if (ContentOf(*step.map) != replay_.Shown(filter_)) {
    life_.broken.push_back(
        absl::StrCat("at revision ", revision.value(), " it is not what the map was"));
  }
  if (step.map->last_capture_time != replay_.last_capture_time()) {
    life_.broken.push_back(absl::StrCat("revision ", revision.value(), " is of another time"));
  }
  CheckEvents(step);
}

void FleetMirror::CheckEvents(const MirrorStep& step) {
  std::vector<std::string> due;
  for (const MapReplay::NumberedEvent& numbered : replay_.TakeEvents()) {
    if (!filter_.Shows(numbered.event)) continue;
    due.push_back(ToProto(numbered.number, numbered.event).SerializeAsString());
  }
  // A snapshot contains no events.
  if (step.is_snapshot) return;
  std::vector<std::string> told;
  for (const NumberedEvent& numbered : step.events) {
    told.push_back(ToProto(numbered.number, numbered.event).SerializeAsString());
  }
  if (told != due) {
    life_.broken.push_back(absl::StrCat("up to revision ",
                                        step.map->revision.value(),
                                        " it told ",
                                        told.size(),
                                        " events, not the ",
                                        due.size(),
                                        " that happened"));
  }
}

}  // namespace steadymap

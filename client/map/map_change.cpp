#include "client/map/map_change.h"

#include <algorithm>
#include <cstdint>
#include <random>
#include <thread>

#include <absl/strings/str_cat.h>

#include "client/map/map_client.h"
#include "client/transport/server_answer.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

// Bounds the retries if another client changes the map continuously.
constexpr int kMaxReads = 10;

std::string NewRequestId() {
  std::random_device device;
  std::string id = "change";
  for (int i = 0; i < 4; ++i) absl::StrAppend(&id, "-", absl::Hex(device(), absl::kZeroPad8));
  return id;
}

void AddClasses(const std::vector<v1::SemanticClass>& added, v1::MapConfig* config) {
  for (const v1::SemanticClass& row : added) {
    auto& table = *config->mutable_classes();
    const auto present = std::find_if(
        table.begin(), table.end(), [&row](const auto& entry) { return entry.id() == row.id(); });
    // Overwrites a row with the same id, so that the server reports which row cannot be changed.
    *(present == table.end() ? table.Add() : &*present) = row;
  }
}

v1::UpdateMapRequest ChangeRequest(const MapChange& change, const v1::Map& present) {
  v1::UpdateMapRequest request;
  request.set_request_id(NewRequestId());
  v1::Map& map = *request.mutable_map();
  map.set_name(present.name());
  map.set_etag(change.etag.empty() ? present.etag() : change.etag);
  auto& mask = *request.mutable_update_mask();
  if (!change.labels.empty() || !change.removed_labels.empty()) {
    *map.mutable_labels() = present.labels();
    for (const std::string& key : change.removed_labels) map.mutable_labels()->erase(key);
    for (const auto& [key, value] : change.labels) (*map.mutable_labels())[key] = value;
    mask.add_paths("labels");
  }
  if (change.world_description) {
    *map.mutable_world_frame() = present.world_frame();
    map.mutable_world_frame()->set_description(*change.world_description);
    mask.add_paths("world_frame");
  }
  if (!change.classes.empty()) {
    *map.mutable_config() = present.config();
    AddClasses(change.classes, map.mutable_config());
    mask.add_paths("config.classes");
  }
  return request;
}

// Sends one request until a server answers it.
absl::StatusOr<v1::Map> SendUntilAnswered(const ChannelOpener& open_channel,
                                          const v1::UpdateMapRequest& request,
                                          const MapChangeOptions& options) {
  using Clock = std::chrono::steady_clock;
  Backoff backoff(options.backoff, std::random_device()());
  for (;;) {
    const Clock::time_point start = Clock::now();
    absl::StatusOr<v1::Map> changed = MapClient(open_channel()).UpdateMap(request);
    if (changed.ok() || IsServerAnswer(changed.status())) return changed;
    FailedTry failed{.was_answered = false};
    if (!options.sleep) {
      failed.took = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start);
    }
    const std::optional<std::chrono::milliseconds> delay = backoff.NextDelay(failed);
    if (!delay) return changed;
    if (options.sleep) {
      options.sleep(*delay);
    } else {
      std::this_thread::sleep_for(*delay);
    }
  }
}

}  // namespace

absl::StatusOr<v1::Map> ChangeMap(const ChannelOpener& open_channel,
                                  const MapName& name,
                                  const MapChange& change,
                                  const MapChangeOptions& options) {
  if (change.is_empty()) {
    return absl::InvalidArgumentError("expected a change of labels, world frame or classes");
  }
  for (int reads = 1;; ++reads) {
    const absl::StatusOr<v1::Map> present = MapClient(open_channel()).GetMap(name);
    if (!present.ok()) return present.status();
    absl::StatusOr<v1::Map> changed =
        SendUntilAnswered(open_channel, ChangeRequest(change, *present), options);
    const bool is_outdated = ReasonOf(changed.status()) == reason::kEtagMismatch;
    if (!is_outdated || !change.etag.empty() || reads == kMaxReads) return changed;
  }
}

}  // namespace steadymap

#include "proto/convert_watch.h"

#include <cassert>
#include <limits>
#include <string>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "proto/convert_geometry.h"

namespace steadymap {
namespace {

constexpr int kMaxWatchedBoxes = 64;
constexpr int kMaxWatchedValues = 1000;

absl::Status CheckWatchedValues(const char* field, int size, int max) {
  if (size <= max) return absl::OkStatus();
  return InvalidField(
      reason::kBadValue, field, absl::StrCat(field, " may hold ", max, " values, got ", size));
}

absl::Status CheckSizes(const v1::WatchFilter& message) {
  absl::Status status = CheckWatchedValues("boxes", message.boxes_size(), kMaxWatchedBoxes);
  status.Update(CheckWatchedValues("class_ids", message.class_ids_size(), kMaxWatchedValues));
  status.Update(CheckWatchedValues("object_ids", message.object_ids_size(), kMaxWatchedValues));
  status.Update(CheckWatchedValues("kinds", message.kinds_size(), kMaxWatchedValues));
  return status;
}

absl::Status ReadKinds(const v1::WatchFilter& message, MapFilter* filter) {
  if (message.kinds().empty()) return absl::OkStatus();
  filter->events = filter->states = filter->volumes = false;
  for (int i = 0; i < message.kinds_size(); ++i) {
    switch (message.kinds(i)) {
      case v1::WATCH_KIND_EVENTS:
        filter->events = true;
        break;
      case v1::WATCH_KIND_OBJECTS:
        filter->states = true;
        break;
      case v1::WATCH_KIND_VOLUMES:
        filter->volumes = true;
        break;
      default:
        return InvalidField(reason::kBadValue,
                            absl::StrCat("kinds[", i, "]"),
                            absl::StrCat("there is no kind ", static_cast<int>(message.kinds(i))));
    }
  }
  return absl::OkStatus();
}

absl::Status ReadClasses(const v1::WatchFilter& message, MapFilter* filter) {
  for (int i = 0; i < message.class_ids_size(); ++i) {
    const std::uint32_t id = message.class_ids(i);
    if (id > std::numeric_limits<std::uint16_t>::max()) {
      return InvalidField(reason::kBadValue,
                          absl::StrCat("class_ids[", i, "]"),
                          absl::StrCat("a class id must be below 65536, got ", id));
    }
    filter->classes.insert(ClassId(static_cast<std::uint16_t>(id)));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<MapFilter> FromProto(const v1::WatchFilter& message) {
  MapFilter filter;
  absl::Status status = CheckSizes(message);
  status.Update(ReadKinds(message, &filter));
  status.Update(ReadClasses(message, &filter));
  if (!status.ok()) return status;
  for (int i = 0; i < message.boxes_size(); ++i) {
    const absl::StatusOr<Box> box_world = FromProto(message.boxes(i));
    if (!box_world.ok()) {
      return WithFieldPrefix(box_world.status(), absl::StrCat("boxes[", i, "]"));
    }
    filter.boxes_world.push_back(*box_world);
  }
  for (const std::uint64_t id : message.object_ids()) filter.objects.insert(ObjectId(id));
  filter.archived = message.include_archived();
  return filter;
}

v1::WatchFilter ToProto(const MapFilter& filter) {
  assert(filter.events || filter.states || filter.volumes);
  v1::WatchFilter message;
  for (const Box& box_world : filter.boxes_world) *message.add_boxes() = ToProto(box_world);
  for (const ClassId id : filter.classes) message.add_class_ids(id.value());
  for (const ObjectId id : filter.objects) message.add_object_ids(id.value());
  if (!(filter.events && filter.states && filter.volumes)) {
    if (filter.events) message.add_kinds(v1::WATCH_KIND_EVENTS);
    if (filter.states) message.add_kinds(v1::WATCH_KIND_OBJECTS);
    if (filter.volumes) message.add_kinds(v1::WATCH_KIND_VOLUMES);
  }
  message.set_include_archived(filter.archived);
  return message;
}

}  // namespace steadymap

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "proto/convert_event.h"
#include "proto/convert_geometry.h"
#include "server/object_answers.h"
#include "server/page_token.h"
#include "server/query_selection.h"

namespace steadymap {
namespace {

constexpr std::uint32_t kDefaultEvents = 1000;
constexpr std::uint32_t kMaxEvents = 10'000;

constexpr std::size_t kEventsPerRead = 1000;
constexpr std::size_t kMaxEventsPassed = 100'000;

/// What a request wants of an event.
struct EventFilter {
  std::set<EventType> types;   ///< Empty: any; so for all sets.
  std::set<ObjectId> objects;  ///< Of the event itself or the related one.
  std::set<ClassId> classes;
  Revision changed_since;
  Timestamp start_time;

  bool Passes(const ObjectEvent& event) const {
    if (event.revision <= changed_since && changed_since.value() > 0) return false;
    if (event.time < start_time) return false;
    if (!types.empty() && !types.contains(event.type)) return false;
    // They concern no object, so they pass no filter of objects.
    if (event.IsOfRobot()) return objects.empty() && classes.empty();
    if (!classes.empty() && !classes.contains(event.class_id)) return false;
    return objects.empty() || objects.contains(event.object) ||
           (event.related != kBackgroundId && objects.contains(event.related));
  }
};

absl::StatusOr<EventFilter> ReadFilter(const v1::ListEventsRequest& request) {
  EventFilter filter;
  absl::Status status = CheckFilterSize("types", request.types_size());
  if (!status.ok()) return status;
  for (int i = 0; i < request.types_size(); ++i) {
    const absl::StatusOr<EventType> type =
        ReadEventType(request.types(i), absl::StrCat("types[", i, "]"));
    if (!type.ok()) return type.status();
    filter.types.insert(*type);
  }
  status = CheckFilterSize("object_ids", request.object_ids_size());
  if (!status.ok()) return status;
  for (const std::uint64_t id : request.object_ids()) filter.objects.insert(ObjectId(id));
  absl::StatusOr<std::set<ClassId>> classes = ReadClassFilter(request.class_ids());
  if (!classes.ok()) return classes.status();
  filter.classes = *std::move(classes);
  filter.changed_since = Revision(request.changed_since());
  if (!request.has_start_time()) return filter;
  const absl::StatusOr<Timestamp> start = FromProto(request.start_time());
  if (!start.ok()) return WithFieldPrefix(start.status(), "start_time");
  filter.start_time = *start;
  return filter;
}

}  // namespace

absl::Status AnswerListEvents(Store& store,
                              MapKey map,
                              Revision revision,
                              const v1::ListEventsRequest& request,
                              v1::ListEventsResponse* response) {
  const absl::StatusOr<EventFilter> filter = ReadFilter(request);
  if (!filter.ok()) return filter.status();
  const absl::StatusOr<std::size_t> page_size =
      ReadPageSize(request.page_size(), kDefaultEvents, kMaxEvents);
  if (!page_size.ok()) return page_size.status();
  const std::string scope = absl::StrCat("events of ", map.value(), " behind ");
  const absl::StatusOr<std::uint64_t> last = ReadNumberToken(scope, request.page_token());
  if (!last.ok()) return last.status();
  response->set_revision(revision.value());
  EventNumber next(std::max(request.first_number(), *last + 1));
  for (std::size_t passed = 0; passed < kMaxEventsPassed; passed += kEventsPerRead) {
    const absl::StatusOr<std::vector<StoredEvent>> events =
        store.ReadEvents(map, next, kEventsPerRead);
    if (!events.ok()) return events.status();
    for (const StoredEvent& stored : *events) {
      // What was committed meanwhile belongs to a later revision.
      if (stored.event.revision > revision) return absl::OkStatus();
      if (!filter->Passes(stored.event)) continue;
      if (static_cast<std::size_t>(response->events_size()) == *page_size) {
        response->set_next_page_token(
            MakePageToken(scope, absl::StrCat(response->events().rbegin()->number())));
        return absl::OkStatus();
      }
      *response->add_events() = ToProto(stored.number, stored.event);
    }
    if (events->size() < kEventsPerRead) return absl::OkStatus();
    next = events->back().number.Next();
  }
  response->set_next_page_token(MakePageToken(scope, absl::StrCat(next.value() - 1)));
  return absl::OkStatus();
}

}  // namespace steadymap

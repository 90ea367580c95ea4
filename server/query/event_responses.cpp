#include "server/query/event_responses.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "proto/convert_event.h"
#include "proto/convert_geometry.h"
#include "server/query/query_selection.h"
#include "server/rpc/page_token.h"

namespace steadymap {
namespace {

constexpr std::uint32_t kDefaultEvents = 1000;
constexpr std::uint32_t kMaxEvents = 10'000;

constexpr std::size_t kEventsPerRead = 1000;
constexpr std::size_t kMaxEventsPassed = 100'000;

/// The filter of a request for events.
struct EventFilter {
  std::set<EventType> types;   ///< Empty: any type.
  std::set<ObjectId> objects;  ///< The event's object or its related one; empty: any.
  std::set<ClassId> classes;
  Revision changed_since;
  Timestamp start_time;
  std::optional<Timestamp> end_time;  ///< Exclusive; none: no limit.

  bool Passes(const ObjectEvent& event) const {
    if (event.revision <= changed_since && changed_since.value() > 0) return false;
    if (event.time < start_time || (end_time && event.time >= *end_time)) return false;
    if (!types.empty() && !types.contains(event.type)) return false;
    // Events of robots concern no object, so no filter of objects or classes accepts them.
    if (event.IsOfRobot()) return objects.empty() && classes.empty();
    if (!classes.empty() && !classes.contains(event.class_id)) return false;
    return objects.empty() || objects.contains(event.object) ||
           (event.related != kBackgroundId && objects.contains(event.related));
  }
};

absl::Status ReadTimes(const v1::ListEventsRequest& request, EventFilter* filter) {
  if (request.has_start_time()) {
    const absl::StatusOr<Timestamp> start = FromProto(request.start_time());
    if (!start.ok()) return WithFieldPrefix(start.status(), "start_time");
    filter->start_time = *start;
  }
  if (request.has_end_time()) {
    const absl::StatusOr<Timestamp> end = FromProto(request.end_time());
    if (!end.ok()) return WithFieldPrefix(end.status(), "end_time");
    if (*end < filter->start_time) {
      return InvalidField(reason::kBadValue, "end_time", "end_time must not be before start_time");
    }
    filter->end_time = *end;
  }
  return absl::OkStatus();
}

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
  status = ReadTimes(request, &filter);
  if (!status.ok()) return status;
  return filter;
}

/// A response page with the events that pass a filter.
class EventPage {
 public:
  EventPage(const EventFilter& filter, std::size_t page_size, v1::ListEventsResponse* response)
      : filter_(filter), page_size_(page_size), response_(response) {}

  /// Adds the event if it passes the filter. Returns false if it passes and the page is full.
  bool Add(const StoredEvent& stored) {
    if (!filter_.Passes(stored.event)) return true;
    if (static_cast<std::size_t>(response_->events_size()) == page_size_ ||
        bytes_ > kMaxPageBytes) {
      return false;
    }
    v1::ObjectEvent* event = response_->add_events();
    *event = ToProto(stored.number, stored.event);
    bytes_ += event->ByteSizeLong();
    return true;
  }

 private:
  const EventFilter& filter_;
  const std::size_t page_size_;
  v1::ListEventsResponse* const response_;
  std::size_t bytes_ = 0;
};

}  // namespace

absl::Status AnswerListEvents(Store& store,
                              MapKey map,
                              const MapSnapshot& snapshot,
                              const v1::ListEventsRequest& request,
                              const Cancellation& cancellation,
                              v1::ListEventsResponse* response) {
  const absl::StatusOr<EventFilter> filter = ReadFilter(request);
  if (!filter.ok()) return filter.status();
  const absl::StatusOr<std::size_t> page_size =
      ReadPageSize(request.page_size(), kDefaultEvents, kMaxEvents);
  if (!page_size.ok()) return page_size.status();
  const std::string scope = ScopeOf("events", map, request);
  const absl::StatusOr<ListingPosition> start = ReadListingToken(
      scope, request.page_token(), {0, snapshot.last_event.value(), snapshot.revision});
  if (!start.ok()) return start.status();
  response->set_revision(start->revision.value());
  EventPage page(*filter, *page_size, response);
  EventNumber next(std::max(request.first_number(), start->last + 1));
  for (std::size_t passed = 0; passed < kMaxEventsPassed; passed += kEventsPerRead) {
    if (absl::Status status = cancellation.Check(); !status.ok()) return status;
    const absl::StatusOr<std::vector<StoredEvent>> events =
        store.ReadEvents(map, next, kEventsPerRead);
    if (!events.ok()) return events.status();
    for (const StoredEvent& stored : *events) {
      // Later events belong to a later revision than that of the first page.
      if (stored.number.value() > start->end) return absl::OkStatus();
      if (!page.Add(stored)) {
        response->set_next_page_token(
            MakeListingToken(scope, {stored.number.value() - 1, start->end, start->revision}));
        return absl::OkStatus();
      }
    }
    if (events->size() < kEventsPerRead) return absl::OkStatus();
    next = events->back().number.Next();
  }
  response->set_next_page_token(
      MakeListingToken(scope, {next.value() - 1, start->end, start->revision}));
  return absl::OkStatus();
}

}  // namespace steadymap

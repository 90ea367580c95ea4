#include "server/query/object_responses.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include <absl/strings/str_cat.h>

#include "core/geometry/cuboid.h"
#include "core/types/error.h"
#include "proto/convert_object.h"
#include "server/query/query_selection.h"
#include "server/rpc/page_token.h"

namespace steadymap {
namespace {

constexpr std::uint32_t kDefaultObjects = 100;
constexpr std::uint32_t kMaxObjects = 1000;

// Objects between two checks for cancellation: at most 2 ms.
constexpr std::size_t kObjectsPerCheck = 256;

/// The filter of a request for objects.
struct ObjectFilter {
  std::set<ClassId> classes;  ///< Empty: any class.
  std::optional<Box> box_world;
  double min_stationarity = 0.0;
  Revision changed_since;
  bool include_archived = false;
  bool include_tentative = false;

  bool Passes(const MapObject& object) const {
    if (object.status == ObjectStatus::kArchived && !include_archived) return false;
    if (object.status == ObjectStatus::kTentative && !include_tentative) return false;
    if (!classes.empty() && !classes.contains(object.class_id)) return false;
    if (object.belief.stationarity() < min_stationarity) return false;
    if (object.revision <= changed_since && changed_since.value() > 0) return false;
    if (!box_world) return true;
    return DistanceBetween(object.cuboid, {box_world->center(), box_world->sizes(), 0.0}) == 0.0;
  }
};

absl::StatusOr<ObjectFilter> ReadFilter(const v1::ListObjectsRequest& request) {
  absl::StatusOr<std::set<ClassId>> classes = ReadClassFilter(request.class_ids());
  if (!classes.ok()) return classes.status();
  const absl::StatusOr<std::optional<Box>> box =
      ReadBox(request.has_box() ? &request.box() : nullptr);
  if (!box.ok()) return box.status();
  // NaN fails the comparison.
  if (!(request.min_stationarity() >= 0.0 && request.min_stationarity() <= 1.0)) {
    return InvalidField(
        reason::kBadValue,
        "min_stationarity",
        absl::StrCat("min_stationarity must lie in [0, 1], got ", request.min_stationarity()));
  }
  return ObjectFilter{*std::move(classes),
                      *box,
                      request.min_stationarity(),
                      Revision(request.changed_since()),
                      request.include_archived(),
                      request.include_tentative()};
}

}  // namespace

absl::Status AnswerGetObject(const MapSnapshot& snapshot,
                             const ObjectName& name,
                             v1::GetObjectResponse* response) {
  const auto found = snapshot.objects.find(name.object);
  if (found == snapshot.objects.end()) {
    return MakeError(absl::StatusCode::kNotFound,
                     reason::kNotFound,
                     absl::StrCat("the map has no object ", name.object.value()),
                     name.object_field);
  }
  response->set_revision(snapshot.revision.value());
  *response->mutable_object() = ToProto(*found->second);
  return absl::OkStatus();
}

absl::Status AnswerListObjects(MapKey map,
                               const MapSnapshot& snapshot,
                               const v1::ListObjectsRequest& request,
                               const Cancellation& cancellation,
                               v1::ListObjectsResponse* response) {
  const absl::StatusOr<ObjectFilter> filter = ReadFilter(request);
  if (!filter.ok()) return filter.status();
  const absl::StatusOr<std::size_t> page_size =
      ReadPageSize(request.page_size(), kDefaultObjects, kMaxObjects);
  if (!page_size.ok()) return page_size.status();
  const std::string scope = ScopeOf("objects", map, request);
  const absl::StatusOr<std::uint64_t> last = ReadNumberToken(scope, request.page_token());
  if (!last.ok()) return last.status();
  response->set_revision(snapshot.revision.value());
  std::size_t bytes = 0;
  std::size_t passed = 0;
  for (auto at = snapshot.objects.upper_bound(ObjectId(*last)); at != snapshot.objects.end();
       ++at) {
    if (passed++ % kObjectsPerCheck == 0) {
      if (absl::Status status = cancellation.Check(); !status.ok()) return status;
    }
    if (!filter->Passes(*at->second)) continue;
    if (static_cast<std::size_t>(response->objects_size()) == *page_size || bytes > kMaxPageBytes) {
      response->set_next_page_token(
          MakePageToken(scope, absl::StrCat(response->objects().rbegin()->id())));
      break;
    }
    v1::Object* object = response->add_objects();
    *object = ToProto(*at->second);
    bytes += object->ByteSizeLong();
  }
  return absl::OkStatus();
}

}  // namespace steadymap

#include "server/query/query_selection.h"

#include <limits>
#include <string>

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include "core/types/absl_text.h"
#include "core/types/error.h"
#include "proto/convert_geometry.h"

namespace steadymap {
namespace {

constexpr int kMaxFilterValues = 1000;

constexpr std::string_view kObjectsInfix = "/objects/";

}  // namespace

absl::StatusOr<ObjectName> ReadObjectName(const v1::GetObjectRequest& request) {
  if (request.name().empty()) return ObjectName{request.map(), ObjectId(request.object_id())};
  if (!request.map().empty() || request.object_id() != 0) {
    return InvalidField(
        reason::kBadValue, "name", "set either name, or map and object_id, not both");
  }
  const std::string_view name = request.name();
  const std::size_t infix = name.rfind(kObjectsInfix);
  if (infix != std::string_view::npos) {
    const std::string_view digits = name.substr(infix + kObjectsInfix.size());
    std::uint64_t id = 0;
    // An object has exactly one name: no sign, space or zero before its digits.
    if (absl::SimpleAtoi(Absl(digits), &id) && std::to_string(id) == digits) {
      return ObjectName{std::string(name.substr(0, infix)), ObjectId(id), "name", "name"};
    }
  }
  return InvalidField(reason::kBadName,
                      "name",
                      "the name of an object must be tenants/{tenant}/maps/{map}/objects/{id}");
}

absl::Status AsOfError() {
  return MakeError(absl::StatusCode::kUnimplemented,
                   reason::kAsOf,
                   "this server can only read the newest revision; omit as_of",
                   "as_of");
}

absl::StatusOr<std::optional<Box>> ReadBox(const v1::Box* message) {
  if (message == nullptr) return std::optional<Box>();
  const absl::StatusOr<Box> box = FromProto(*message);
  if (!box.ok()) return WithFieldPrefix(box.status(), "box");
  return std::optional<Box>(*box);
}

absl::StatusOr<std::vector<PlacedVolume>> SelectVolumes(
    const MapSnapshot& snapshot, const google::protobuf::RepeatedField<std::uint64_t>& object_ids) {
  if (object_ids.empty()) return ShownVolumes(snapshot);
  std::set<ObjectId> chosen;
  for (int i = 0; i < object_ids.size(); ++i) {
    const ObjectId id(object_ids[i]);
    if (id != kBackgroundId && !snapshot.objects.contains(id)) {
      return MakeError(absl::StatusCode::kNotFound,
                       reason::kNotFound,
                       absl::StrCat("the map has no object ", object_ids[i]),
                       absl::StrCat("object_ids[", i, "]"));
    }
    chosen.insert(id);
  }
  std::vector<PlacedVolume> volumes;
  volumes.reserve(chosen.size());
  for (const ObjectId id : chosen) {
    volumes.push_back(id == kBackgroundId ? BackgroundOf(snapshot)
                                          : VolumeOf(*snapshot.objects.at(id)));
  }
  return volumes;
}

absl::StatusOr<std::set<ClassId>> ReadClassFilter(
    const google::protobuf::RepeatedField<std::uint32_t>& class_ids) {
  if (absl::Status status = CheckFilterSize("class_ids", class_ids.size()); !status.ok()) {
    return status;
  }
  std::set<ClassId> classes;
  for (int i = 0; i < class_ids.size(); ++i) {
    if (class_ids[i] > std::numeric_limits<std::uint16_t>::max()) {
      return InvalidField(reason::kBadValue,
                          absl::StrCat("class_ids[", i, "]"),
                          absl::StrCat("a class id must be below 65536, got ", class_ids[i]));
    }
    classes.insert(ClassId(static_cast<std::uint16_t>(class_ids[i])));
  }
  return classes;
}

absl::Status CheckFilterSize(std::string_view field, int size) {
  if (size <= kMaxFilterValues) return absl::OkStatus();
  return InvalidField(
      reason::kBadValue,
      field,
      absl::StrCat(
          std::string(field), " must have at most ", kMaxFilterValues, " values, got ", size));
}

}  // namespace steadymap

#include "server/query_selection.h"

#include <limits>
#include <string>

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "proto/convert_geometry.h"

namespace steadymap {
namespace {

constexpr int kMaxFilterValues = 1000;

}  // namespace

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
      absl::StrCat(std::string(field), " may name ", kMaxFilterValues, " values, got ", size));
}

}  // namespace steadymap

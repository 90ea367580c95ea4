#include "server/query_selection.h"

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "core/identifiers.h"
#include "proto/convert_geometry.h"

namespace steadymap {

absl::StatusOr<std::optional<Box>> ReadBox(const v1::Box* message) {
  if (message == nullptr) return std::optional<Box>();
  const absl::StatusOr<Box> box = FromProto(*message);
  if (!box.ok()) return WithFieldPrefix(box.status(), "box");
  return std::optional<Box>(*box);
}

absl::Status CheckObjects(const google::protobuf::RepeatedField<std::uint64_t>& object_ids) {
  for (int i = 0; i < object_ids.size(); ++i) {
    if (ObjectId(object_ids[i]) == kBackgroundId) continue;
    return MakeError(absl::StatusCode::kNotFound,
                     reason::kNotFound,
                     absl::StrCat("the map has no object ", object_ids[i]),
                     absl::StrCat("object_ids[", i, "]"));
  }
  return absl::OkStatus();
}

}  // namespace steadymap

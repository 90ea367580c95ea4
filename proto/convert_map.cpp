#include "proto/convert_map.h"

#include <cstdint>
#include <limits>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

absl::StatusOr<ClassMotion> MotionOf(v1::ClassMotion motion) {
  switch (motion) {
    case v1::CLASS_MOTION_UNSPECIFIED:
    case v1::CLASS_MOTION_STATIC:
      return ClassMotion::kStatic;
    case v1::CLASS_MOTION_SEMI_STATIC:
      return ClassMotion::kSemiStatic;
    case v1::CLASS_MOTION_DYNAMIC:
      return ClassMotion::kDynamic;
    default:
      return InvalidField(
          reason::kBadValue,
          "motion",
          absl::StrCat("the motion must be one that is known, got ", static_cast<int>(motion)));
  }
}

v1::ClassMotion MotionToProto(ClassMotion motion) {
  switch (motion) {
    case ClassMotion::kStatic:
      return v1::CLASS_MOTION_STATIC;
    case ClassMotion::kSemiStatic:
      return v1::CLASS_MOTION_SEMI_STATIC;
    case ClassMotion::kDynamic:
      return v1::CLASS_MOTION_DYNAMIC;
  }
  return v1::CLASS_MOTION_UNSPECIFIED;
}

absl::StatusOr<SemanticClass> ClassFromProto(const v1::SemanticClass& message) {
  if (message.id() > std::numeric_limits<std::uint16_t>::max()) {
    return InvalidField(reason::kBadValue,
                        "id",
                        absl::StrCat("a class id must be below 65536, got ", message.id()));
  }
  absl::StatusOr<ClassMotion> motion = MotionOf(message.motion());
  if (!motion.ok()) return motion.status();
  return SemanticClass{ClassId(static_cast<std::uint16_t>(message.id())),
                       message.name(),
                       *motion,
                       message.in_background()};
}

}  // namespace

absl::StatusOr<std::vector<SemanticClass>> ReadClasses(const v1::MapConfig& message) {
  if (message.classes_size() > kMaxClasses) {
    return InvalidField(
        reason::kBadValue,
        "classes",
        absl::StrCat(
            "a class table has at most ",
            kMaxClasses,
            " rows, got ",
            message.classes_size(),
            "; ids may be anything below 65536, so only classes that are used need a row"));
  }
  std::vector<SemanticClass> classes;
  classes.reserve(static_cast<std::size_t>(message.classes_size()));
  for (int i = 0; i < message.classes_size(); ++i) {
    absl::StatusOr<SemanticClass> row = ClassFromProto(message.classes(i));
    if (!row.ok()) return WithFieldPrefix(row.status(), absl::StrCat("classes[", i, "]"));
    classes.push_back(*std::move(row));
  }
  return classes;
}

absl::StatusOr<MapConfig> FromProto(const v1::MapConfig& message) {
  MapConfig config;
  if (message.voxel_size_m() != 0.0) config.voxel_size_m = message.voxel_size_m();
  config.truncation_m = message.truncation_m() != 0.0 ? message.truncation_m()
                                                      : DefaultTruncationM(config.voxel_size_m);
  if (message.max_depth_m() != 0.0) config.max_depth_m = message.max_depth_m();
  const absl::StatusOr<UpdatePolicy> policy = FromProto(message.policy());
  if (!policy.ok()) return policy.status();
  config.policy = *policy;
  config.parameters.insert(message.parameters().begin(), message.parameters().end());
  if (message.classes_size() > 0) {
    absl::StatusOr<std::vector<SemanticClass>> classes = ReadClasses(message);
    if (!classes.ok()) return classes.status();
    config.classes = *std::move(classes);
  }
  if (absl::Status status = ValidateMapConfig(config); !status.ok()) return status;
  return config;
}

v1::MapConfig ToProto(const MapConfig& config) {
  v1::MapConfig message;
  message.set_voxel_size_m(config.voxel_size_m);
  message.set_truncation_m(config.truncation_m);
  message.set_max_depth_m(config.max_depth_m);
  message.set_policy(ToProto(config.policy));
  message.mutable_parameters()->insert(config.parameters.begin(), config.parameters.end());
  for (const SemanticClass& row : config.classes) {
    v1::SemanticClass* added = message.add_classes();
    added->set_id(row.id.value());
    added->set_name(row.name);
    added->set_motion(MotionToProto(row.motion));
    added->set_in_background(row.in_background);
  }
  return message;
}

absl::StatusOr<UpdatePolicy> FromProto(v1::UpdatePolicy policy) {
  switch (policy) {
    case v1::UPDATE_POLICY_UNSPECIFIED:
    case v1::UPDATE_POLICY_STATIC:
      return UpdatePolicy::kStatic;
    case v1::UPDATE_POLICY_VOXEL_CHANGE:
      return UpdatePolicy::kVoxelChange;
    case v1::UPDATE_POLICY_SUBMAP_CHANGE:
      return UpdatePolicy::kSubmapChange;
    case v1::UPDATE_POLICY_TRACKING:
      return UpdatePolicy::kTracking;
    case v1::UPDATE_POLICY_POCD:
      return UpdatePolicy::kPocd;
    case v1::UPDATE_POLICY_POCD_PAPER:
      return UpdatePolicy::kPocdPaper;
    default:
      return InvalidField(
          reason::kBadValue,
          "policy",
          absl::StrCat("the policy must be one that is known, got ", static_cast<int>(policy)));
  }
}

v1::UpdatePolicy ToProto(UpdatePolicy policy) {
  switch (policy) {
    case UpdatePolicy::kStatic:
      return v1::UPDATE_POLICY_STATIC;
    case UpdatePolicy::kVoxelChange:
      return v1::UPDATE_POLICY_VOXEL_CHANGE;
    case UpdatePolicy::kSubmapChange:
      return v1::UPDATE_POLICY_SUBMAP_CHANGE;
    case UpdatePolicy::kTracking:
      return v1::UPDATE_POLICY_TRACKING;
    case UpdatePolicy::kPocd:
      return v1::UPDATE_POLICY_POCD;
    case UpdatePolicy::kPocdPaper:
      return v1::UPDATE_POLICY_POCD_PAPER;
  }
  return v1::UPDATE_POLICY_UNSPECIFIED;
}

}  // namespace steadymap

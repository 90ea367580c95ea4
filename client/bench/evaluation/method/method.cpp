#include "client/bench/evaluation/method/method.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "core/types/policy_parameters.h"

namespace steadymap {
namespace {

struct MethodRow {
  std::string_view name;
  void (*choose)(MapConfig* config);  ///< Sets the policy.
  bool is_yardstick = false;
  bool last_sequence_only = false;
};

void FuseEverything(MapConfig* config) { config->policy = UpdatePolicy::kStatic; }

void OverwriteVoxels(MapConfig* config) { config->policy = UpdatePolicy::kVoxelChange; }

void SwitchSubmaps(MapConfig* config) { config->policy = UpdatePolicy::kSubmapChange; }

void FollowObjects(MapConfig* config) { config->policy = UpdatePolicy::kTracking; }

void KeepObjects(MapConfig* config) { config->policy = UpdatePolicy::kPocd; }

void FollowThePaper(MapConfig* config) { config->policy = UpdatePolicy::kPocdPaper; }

// One line per method. `static` is a map that never removes surface, `fresh` a map of the last
// sequence alone.
constexpr std::array<MethodRow, 7> kMethods = {{
    {"static", FuseEverything, true, false},
    {"fresh", FuseEverything, true, true},
    {"voxel_change", OverwriteVoxels},
    {"submap_change", SwitchSubmaps},
    {"tracking", FollowObjects},
    {"pocd_paper", FollowThePaper},
    {"pocd", KeepObjects},
}};

}  // namespace

std::vector<std::string> MethodNames() {
  std::vector<std::string> names;
  names.reserve(kMethods.size());
  for (const MethodRow& row : kMethods) names.emplace_back(row.name);
  return names;
}

absl::StatusOr<std::vector<Method>> SelectMethods(const std::vector<std::string>& names,
                                                  const MapConfig& base) {
  const std::vector<std::string> known = MethodNames();
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string message = "unknown policy \"" + name.substr(0, 80) + "\"; the policies are";
    for (const std::string& other : known) message += " " + other;
    return absl::InvalidArgumentError(message);
  }
  std::vector<Method> methods;
  for (const MethodRow& row : kMethods) {
    const bool is_wanted =
        names.empty() || std::find(names.begin(), names.end(), row.name) != names.end();
    if (!row.is_yardstick && !is_wanted) continue;
    Method& method = methods.emplace_back();
    method.name = row.name;
    method.config = base;
    method.last_sequence_only = row.last_sequence_only;
    row.choose(&method.config);
    std::erase_if(method.config.parameters, [&](const auto& parameter) {
      return FindParameter(method.config.policy, parameter.first) == nullptr;
    });
    if (absl::Status status = ValidateMapConfig(method.config); !status.ok()) return status;
  }
  for (const auto& parameter : base.parameters) {
    const std::string& name = parameter.first;
    const bool is_used = std::any_of(methods.begin(), methods.end(), [&](const Method& method) {
      return method.config.parameters.contains(name);
    });
    if (is_used) continue;
    return absl::InvalidArgumentError("no policy here has a parameter \"" + name.substr(0, 80) +
                                      "\"; map create --help lists them");
  }
  return methods;
}

}  // namespace steadymap

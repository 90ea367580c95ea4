#include "client/bench/evaluation/method/method.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace steadymap {
namespace {

struct MethodRow {
  std::string_view name;
  void (*choose)(MapConfig* config);  ///< Sets the policy and its switches.
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

constexpr std::string_view kAllSwitches = "all";

// Returns the switches in order, each once.
absl::StatusOr<std::vector<std::string>> ListSwitches(const std::vector<std::string>& names) {
  std::vector<std::string> listed;
  const auto list = [&listed](std::string_view name) {
    if (std::find(listed.begin(), listed.end(), name) == listed.end()) listed.emplace_back(name);
  };
  for (const std::string& name : names) {
    if (name == kAllSwitches) {
      for (const AblationSwitch& row : AllAblationSwitches()) list(row.name);
      continue;
    }
    if (const absl::Status known = AllOnBut(name).status(); !known.ok()) return known;
    list(name);
  }
  return listed;
}

// Appends `whole` without one switch, for each switch.
void AppendWithout(const std::vector<std::string>& switches,
                   const Method& whole,
                   std::vector<Method>* methods) {
  for (const std::string& name : switches) {
    Method& method = methods->emplace_back(whole);
    method.name = whole.name + " -" + name;
    method.switches = AllOnBut(name).value();
  }
}

}  // namespace

std::vector<std::string> SwitchNames() {
  std::vector<std::string> names;
  for (const AblationSwitch& row : AllAblationSwitches()) names.emplace_back(row.name);
  names.emplace_back(kAllSwitches);
  return names;
}

std::vector<std::string> MethodNames() {
  std::vector<std::string> names;
  names.reserve(kMethods.size());
  for (const MethodRow& row : kMethods) names.emplace_back(row.name);
  return names;
}

absl::StatusOr<std::vector<Method>> SelectMethods(const std::vector<std::string>& names,
                                                  const MapConfig& base,
                                                  const std::vector<std::string>& switched_off) {
  const std::vector<std::string> known = MethodNames();
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string message = "unknown policy \"" + name.substr(0, 80) + "\"; the policies are";
    for (const std::string& other : known) message += " " + other;
    return absl::InvalidArgumentError(message);
  }
  const absl::StatusOr<std::vector<std::string>> switches = ListSwitches(switched_off);
  if (!switches.ok()) return switches.status();
  bool has_switches = switches->empty();
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
    if (method.config.policy != UpdatePolicy::kPocd) continue;
    has_switches = true;
    AppendWithout(*switches, Method(method), &methods);
  }
  if (!has_switches) {
    return absl::InvalidArgumentError("switches can only be turned off with the policy pocd");
  }
  return methods;
}

}  // namespace steadymap

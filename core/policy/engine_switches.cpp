#include "core/policy/engine_switches.h"

#include <array>

namespace steadymap {
namespace {

constexpr std::array<EngineSwitch, 19> kEngineSwitches = {{
    {"visibility",
     "an unmatched object in the frustum is contradicted, hidden or not",
     &EngineSwitches::visibility_by_depth},
    {"far-labels",
     "things before what is out of the sensor's reach are never gone",
     &EngineSwitches::far_labels},
    {"cuboid-gate",
     "clusters find objects by the distance of their centres",
     &EngineSwitches::cuboid_gate},
    {"many-to-one",
     "clusters are matched whole, one with one object of their class",
     &EngineSwitches::many_to_one},
    {"merging", "objects that turn out to be one stay two", &EngineSwitches::merging},
    {"splitting", "objects leave the map as a whole or not at all", &EngineSwitches::splitting},
    {"archive", "removed objects are forgotten", &EngineSwitches::archive},
    {"returning", "what comes back is a new object", &EngineSwitches::returning},
    {"moves", "what moved is removed here and created there", &EngineSwitches::moves},
    {"robot-guard", "every pose is believed", &EngineSwitches::robot_guard},
    {"turning",
     "what was turned in its place is held for what stood there",
     &EngineSwitches::turning},
    {"replacing", "what newer surface hides stays in the map", &EngineSwitches::replacing},
    {"free-space", "space that was looked through is not remembered", &EngineSwitches::free_space},
    {"tentative", "objects are in the map from the first frame on", &EngineSwitches::tentative},
    {"gathering",
     "beliefs change with every frame, however little it shows",
     &EngineSwitches::gathering},
    {"evidence-cap", "beliefs grow without bound", &EngineSwitches::evidence_cap},
    {"clean-change",
     "changes are clamped to the truncation, and noise counts as change",
     &EngineSwitches::clean_change},
    {"dynamic-mask",
     "people and vehicles are fused like everything else",
     &EngineSwitches::dynamic_mask},
    {"moving-memory",
     "what moves is fused in frames that take it for something else",
     &EngineSwitches::moving_memory},
}};

}  // namespace

std::span<const EngineSwitch> AllEngineSwitches() { return kEngineSwitches; }

absl::StatusOr<EngineSwitches> AllOnBut(const std::string& name) {
  std::string message = "there is no switch \"" + name.substr(0, 80) + "\"; the switches are";
  for (const EngineSwitch& row : kEngineSwitches) {
    if (row.name == name) {
      EngineSwitches switches;
      switches.*row.is_on = false;
      return switches;
    }
    message.append(" ").append(row.name);
  }
  return absl::InvalidArgumentError(message);
}

}  // namespace steadymap

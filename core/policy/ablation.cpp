#include "core/policy/ablation.h"

#include <array>

namespace steadymap {
namespace {

constexpr std::array<AblationSwitch, 19> kAblationSwitches = {{
    {"visibility",
     "an unmatched object in the frustum is contradicted, hidden or not",
     &Ablation::visibility_by_depth},
    {"far-labels",
     "things before what is out of the sensor's reach are never gone",
     &Ablation::far_labels},
    {"cuboid-gate",
     "clusters find objects by the distance of their centres",
     &Ablation::cuboid_gate},
    {"many-to-one",
     "clusters are matched whole, one with one object of their class",
     &Ablation::many_to_one},
    {"merging", "objects that turn out to be one stay two", &Ablation::merging},
    {"splitting", "objects leave the map as a whole or not at all", &Ablation::splitting},
    {"archive", "removed objects are forgotten", &Ablation::archive},
    {"returning", "what comes back is a new object", &Ablation::returning},
    {"moves", "what moved is removed here and created there", &Ablation::moves},
    {"robot-guard", "every pose is believed", &Ablation::robot_guard},
    {"turning", "what was turned in its place is held for what stood there", &Ablation::turning},
    {"replacing", "what newer surface hides stays in the map", &Ablation::replacing},
    {"free-space", "space that was looked through is not remembered", &Ablation::free_space},
    {"tentative", "objects are in the map from the first frame on", &Ablation::tentative},
    {"gathering", "beliefs change with every frame, however little it shows", &Ablation::gathering},
    {"evidence-cap", "beliefs grow without bound", &Ablation::evidence_cap},
    {"clean-change",
     "changes are clamped to the truncation, and noise counts as change",
     &Ablation::clean_change},
    {"dynamic-mask", "people and vehicles are fused like everything else", &Ablation::dynamic_mask},
    {"moving-memory",
     "what moves is fused in frames that take it for something else",
     &Ablation::moving_memory},
}};

}  // namespace

std::span<const AblationSwitch> AllAblationSwitches() { return kAblationSwitches; }

absl::StatusOr<Ablation> AllOnBut(const std::string& name) {
  std::string message = "there is no switch \"" + name.substr(0, 80) + "\"; the switches are";
  for (const AblationSwitch& row : kAblationSwitches) {
    if (row.name == name) {
      Ablation switches;
      switches.*row.is_on = false;
      return switches;
    }
    message.append(" ").append(row.name);
  }
  return absl::InvalidArgumentError(message);
}

}  // namespace steadymap

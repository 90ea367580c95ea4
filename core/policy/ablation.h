#pragma once

#include <span>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

/// What the `pocd` policy has beyond its paper, to be taken away piece by piece.
namespace steadymap {

/// The extensions of the `pocd` policy that are on. Without an extension the policy does as the
/// paper describes (Qian et al., RSS 2022), or nothing where the paper has no such step. Set when a
/// mapper is created; a map that was begun with other switches is a map of another policy.
struct Ablation {
  /// Absence is told by depth beyond the surface. Off: by an object in the frustum, occluded or
  /// not, that nothing was matched with.
  bool visibility_by_depth = true;
  /// Where nothing returns, a label of what stays tells that one looks past a thing.
  bool far_labels = true;
  /// What lies within an object's bounds may be of it. Off: only what belongs to a cluster whose
  /// centre lies near that of the object (theta_dist).
  bool cuboid_gate = true;
  /// Each sample finds its own object, and surface that is not mapped yet speaks against nothing.
  /// Off: clusters of one label, whole, each for one object of that class at most, and only if
  /// hardly anything of them is unknown (theta_sim).
  bool many_to_one = true;
  /// Objects that turn out to be connected become one, and narrow pieces join what they are of.
  bool merging = true;
  /// What is gone of an object is cut off while the rest stands, and what stood on when the rest
  /// went is known as such. Off: objects go as a whole.
  bool splitting = true;
  /// Removed objects are kept as history. Off: they are forgotten, so that none comes back, and of
  /// the moves only those aside are left.
  bool archive = true;
  /// What comes back to its place is known again.
  bool returning = true;
  /// What left one place and is new in another has moved.
  bool moves = true;
  /// Frames of a robot that is not where it says do not count.
  bool robot_guard = true;
  /// What was turned where it stands is no longer what stood there.
  bool turning = true;
  /// Surface close behind newer surface of its class is gone, though nobody can look there.
  bool replacing = true;
  /// Space that was looked through is remembered, which tells new things from more of old ones.
  bool free_space = true;
  /// New objects wait until several frames agree. Off: one is enough.
  bool tentative = true;
  /// A belief changes when enough of the surface was judged. Off: with every frame.
  bool gathering = true;
  /// Beliefs hold no more than so much evidence, less where long nobody looked. Off: no bound.
  bool evidence_cap = true;
  /// The measured change is neither clamped to the truncation nor raised by noise.
  bool clean_change = true;
  /// Pixels of dynamic classes are not fused. Off: they are, like all others.
  bool dynamic_mask = true;
  /// Where something of a dynamic class was seen a moment ago, nothing is fused.
  bool moving_memory = true;

  friend bool operator==(const Ablation&, const Ablation&) = default;
};

/// One of them.
struct AblationSwitch {
  std::string_view name;  ///< Lower case, words joined by hyphens.
  std::string_view off;   ///< What the map is like without, half a sentence.
  bool Ablation::*is_on;
};

/// All switches, in the order of the struct.
std::span<const AblationSwitch> AllAblationSwitches();

/// All on but the one called `name`.
/// Errors: `InvalidArgument`, listing the names there are.
absl::StatusOr<Ablation> AllOnBut(const std::string& name);

}  // namespace steadymap

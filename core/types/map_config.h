#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// How a map decides what to believe.
enum class UpdatePolicy {
  kStatic,        ///< Every frame is fused, nothing is ever removed.
  kVoxelChange,   ///< Voxels are overwritten where a visit disagrees with those before.
  kSubmapChange,  ///< Objects are in or out as a whole by the last look at them.
  kTracking,      ///< Objects are followed from frame to frame; what is gone stays.
  kPocd,          ///< Objects with a belief each, whether they still stand where they stood.
  kPocdPaper,     ///< The same as the paper has it, without what steadymap adds: to compare with.
};

/// Whether things of a class move on their own.
enum class ClassMotion {
  kStatic,      ///< Stays where it is until somebody rebuilds the place: walls, racks.
  kSemiStatic,  ///< Stays for hours or days, then is moved: goods, carts.
  kDynamic,     ///< Moves while it is looked at: people, vehicles. Its pixels are never fused.
};

/// One row of a map's class table.
struct SemanticClass {
  ClassId id;        ///< The value in label images.
  std::string name;  ///< For people, 1 to 64 characters.
  ClassMotion motion = ClassMotion::kStatic;
  /// Whether its surfaces belong to the background instead of forming objects: ground, ceiling, and
  /// whatever has no class.
  bool in_background = false;

  friend bool operator==(const SemanticClass&, const SemanticClass&) = default;
};

/// The classes of the TorWIC data set (pocd.md section 5), ids 0 to 15.
std::vector<SemanticClass> TorwicClasses();

/// How a map is built. Immutable after creation, so that a replay of its log gives the same map.
struct MapConfig {
  /// Edge of a voxel, metres, in [0.001, 1]. Memory grows with its inverse square. TorWIC: 0.05.
  double voxel_size_m = 0.05;

  /// Distances are kept within this of a surface, metres, in [2, 16] voxels. Wider bridges more
  /// noise, narrower keeps the two sides of thin things apart.
  double truncation_m = 0.15;

  /// Depth beyond this is not fused, metres, in [0.1, 100], at most 4000 voxels, which bounds the
  /// work of a frame. TorWIC: 3.
  double max_depth_m = 3.0;

  UpdatePolicy policy = UpdatePolicy::kStatic;

  /// Classes that label images may hold besides 0, which means no label; unique ids. Never empty in
  /// a valid configuration.
  std::vector<SemanticClass> classes = TorwicClasses();

  /// The largest id plus one, at least 1: labels of a valid frame lie below this.
  std::size_t label_limit() const;

  /// The row of a class; null if it has none. Valid until the table changes.
  const SemanticClass* FindClass(ClassId id) const;

  /// Whether surface of a class belongs to the background; so does that of a class without a row.
  bool IsInBackground(ClassId id) const;

  friend bool operator==(const MapConfig&, const MapConfig&) = default;
};

/// The values that label images of a map may hold: the ids of its class table, and 0, which means
/// no label. Any thread.
class KnownLabels {
 public:
  explicit KnownLabels(const std::vector<SemanticClass>& classes);

  bool Contains(std::uint16_t label) const { return label < is_known_.size() && is_known_[label]; }

  /// Every known label lies below this; at least 1.
  std::size_t limit() const { return is_known_.size(); }

  /// Whether all labels below `limit()` are known.
  bool is_dense() const { return is_dense_; }

 private:
  std::vector<bool> is_known_;
  bool is_dense_ = true;
};

/// OK if a map can be built so; else `InvalidArgument` with reason `BAD_VALUE` and the field path
/// (proto spelling) of the first violation, and all violations in the message.
absl::Status ValidateMapConfig(const MapConfig& config);

}  // namespace steadymap

#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// The method by which a map is updated. Sources: `core/README.md`.
enum class UpdatePolicy {
  kStatic,        ///< Fuses every frame; rays clear what they pass through.
  kVoxelChange,   ///< Overwrites voxels where the current visit contradicts earlier visits.
  kSubmapChange,  ///< Includes or excludes whole objects by their latest comparison with a frame.
  kTracking,      ///< Registers objects in every frame. Absent objects stay in the map.
  kPocd,          ///< Keeps a belief of the stationarity of each object.
  kPocdPaper,     ///< POCD as published, without the extensions of `kPocd`; for comparison.
};

/// Whether, and how often, objects of a class move.
enum class ClassMotion {
  kStatic,      ///< Never moves, except by reconstruction of the building: walls, racks.
  kSemiStatic,  ///< Stays for hours or days between moves: goods, carts.
  kDynamic,     ///< Moves while it is observed: people, vehicles. Its pixels are never fused.
};

/// One row of a map's class table.
struct SemanticClass {
  ClassId id;        ///< The value in label images.
  std::string name;  ///< Display name, 1 to 64 bytes.
  ClassMotion motion = ClassMotion::kStatic;
  /// True if surface of the class belongs to the background and forms no objects: ground, ceiling,
  /// unclassified surface.
  bool in_background = false;

  friend bool operator==(const SemanticClass&, const SemanticClass&) = default;
};

/// Returns the classes of the TorWIC data set (Qian et al., RSS 2022), ids 0 to 15.
std::vector<SemanticClass> TorwicClasses();

/// Values of parameters of a policy by name.
using ParameterValues = std::map<std::string, double, std::less<>>;

/// The configuration of a map. Immutable after creation, so that a replay of the log gives the same
/// map.
struct MapConfig {
  /// Edge length of a voxel, metres, in [0.001, 1]. Memory grows with its inverse square. TorWIC:
  /// 0.05.
  double voxel_size_m = 0.05;

  /// Truncation distance, metres, in [2, 16] voxels. A larger value tolerates more noise; a smaller
  /// value keeps the two sides of thin objects apart.
  double truncation_m = 0.15;

  /// Depth beyond this limit is not fused, metres, in [0.1, 100], at most 4000 voxels, which bounds
  /// the work per frame. TorWIC: 3.
  double max_depth_m = 3.0;

  UpdatePolicy policy = UpdatePolicy::kStatic;

  /// The classes that label images may contain, with unique ids, besides 0, which means no label.
  /// Never empty in a valid configuration.
  std::vector<SemanticClass> classes = TorwicClasses();

  /// Values of the policy's parameters that are not the default, by name (`policy_parameters.h`).
  ParameterValues parameters{};

  /// Returns the largest id plus one, at least 1. Labels of a valid frame are below this value.
  std::size_t label_limit() const;

  /// Returns the row of a class, null if it has none. Valid until the table changes.
  const SemanticClass* FindClass(ClassId id) const;

  /// True if surface of the class belongs to the background. Also true for a class without a row.
  bool IsInBackground(ClassId id) const;

  friend bool operator==(const MapConfig&, const MapConfig&) = default;
};

/// Returns the truncation distance of a map whose creator states none: three voxels, rounded to
/// micrometres.
double DefaultTruncationM(double voxel_size_m);

/// The set of valid values in label images of a map: the ids of its class table, and 0, which means
/// no label. Thread-safe.
class KnownLabels {
 public:
  explicit KnownLabels(const std::vector<SemanticClass>& classes);

  bool Contains(std::uint16_t label) const { return label < is_known_.size() && is_known_[label]; }

  /// Returns an upper bound of the known labels, exclusive; at least 1.
  std::size_t limit() const { return is_known_.size(); }

  /// True if all labels below `limit()` are known.
  bool is_dense() const { return is_dense_; }

 private:
  std::vector<bool> is_known_;
  bool is_dense_ = true;
};

/// Returns OK if a map can be built with the configuration. Errors: `InvalidArgument` with reason
/// `BAD_VALUE`, the field path (proto spelling) of the first violation, and a message that lists
/// the first ten violations.
absl::Status ValidateMapConfig(const MapConfig& config);

/// Removes the parameters that `ValidateMapConfig` rejects, so that their defaults apply. Returns
/// their names in order. For a configuration that an earlier version wrote: parameters and ranges
/// change with the engine.
std::vector<std::string> RemoveInvalidParameters(MapConfig* config);

}  // namespace steadymap

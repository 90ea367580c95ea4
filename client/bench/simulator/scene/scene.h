#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "client/bench/simulator/scene/shape.h"
#include "core/frame/frame.h"

namespace steadymap {

/// The classes of simulated scenes: the class table of TorWIC.
enum class SceneClass : std::uint16_t {
  kBackground = 0,
  kGround = 1,
  kWall = 4,  ///< Wall, fence, pillar.
  kStaticFeature = 5,
  kRack = 6,
  kGoods = 7,
  kMachinery = 8,
  kPylon = 10,
  kText = 11,
  kNonStaticFeature = 12,
  kPerson = 13,
  kForklift = 14,
  kDynamicFeature = 15,
};

/// Number of classes in the table of `SceneClass`.
inline constexpr std::uint16_t kSceneClassCount = 16;

/// Pose of a moving object at one time of a sequence.
struct MotionKey {
  double time_s = 0.0;  ///< Since the start of the sequence.
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
};

/// One object of a scene. It keeps its id in all configurations of a route, which defines the truth
/// about moves.
struct SceneObject {
  std::uint16_t id = 0;        ///< Unique within the scene, at least 1; set by `Scene::Add`.
  std::uint16_t instance = 0;  ///< Value in instance images: the id, or 0 for non-objects.
  std::string name;            ///< For display, e.g. `outer-top-2-a`.
  std::string group;           ///< Common to touching objects of equal look; may be empty.
  SceneClass semantic_class = SceneClass::kBackground;
  Rgb color = {128, 128, 128};
  Shape shape;
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();  ///< Used without `motion`.
  std::vector<MotionKey> motion;  ///< Ascending times; linear between keys, at rest outside.

  /// True if the object moves during a sequence.
  bool moves() const { return !motion.empty(); }

  /// Returns its pose `time_s` seconds after the start of the sequence.
  Eigen::Isometry3d PoseAt(double time_s) const;
};

/// One configuration of the world: all objects of one sequence.
///
/// A value type: scenarios copy a scene and change the copy.
class Scene {
 public:
  /// Adds an object with the next id and returns it for further settings. The reference is valid
  /// until the next `Add` or `RemoveIf`. At most 65535 objects (asserted).
  SceneObject& Add(SceneObject object);

  /// Removes the objects for which `predicate(object)` is true. Ids are not reused.
  template <typename Predicate>
  void RemoveIf(Predicate predicate) {
    std::erase_if(objects_, predicate);
  }

  /// All objects, in ascending order of id.
  const std::vector<SceneObject>& objects() const { return objects_; }

  std::vector<SceneObject>& objects() { return objects_; }

  /// Returns the object with this id, or null.
  const SceneObject* Find(std::uint16_t id) const;

 private:
  std::vector<SceneObject> objects_;
  std::uint16_t last_id_ = 0;
};

/// Returns the smallest box around an object without `motion`, world frame, metres.
Eigen::AlignedBox3d BoxOf(const SceneObject& object);

/// Difference between two configurations of one route.
struct SceneChange {
  std::vector<std::uint16_t> created;  ///< Ids, ascending.
  std::vector<std::uint16_t> removed;  ///< Ids, ascending.
  std::vector<std::uint16_t> moved;    ///< Ids, ascending; the poses are in the two scenes.
};

/// Compares two configurations. An object that moves during a sequence is compared by its pose at
/// the start of it; poses differ beyond 1 mm or 0.1 degrees.
SceneChange CompareScenes(const Scene& before, const Scene& after);

/// Adds a box on the ground (z = 0), centred at (`x_m`, `y_m`), rotated by `yaw_rad`. Its class is
/// goods and its instance is its id; modify the returned object for other values.
SceneObject& AddStandingBox(Scene* scene,
                            std::string_view name,
                            const Eigen::Vector3d& size_m,
                            const Eigen::Vector3d& x_y_yaw);

/// Adds a floor at z = 0, centred at the origin; no instance.
SceneObject& AddFloor(Scene* scene, const Eigen::Vector2d& size_m);

}  // namespace steadymap

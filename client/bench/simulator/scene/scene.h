#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "client/bench/simulator/scene/shape.h"
#include "core/frame/frame.h"

namespace steadymap {

/// The classes that scenes use: those of `TorwicClasses` in core/types/map_config.h.
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

/// Number of classes in that table.
inline constexpr std::uint16_t kSceneClassCount = 16;

/// Where a moving object is at one moment of a sequence.
struct MotionKey {
  double time_s = 0.0;  ///< Since the start of the sequence.
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
};

/// One thing of a scene. Its id stays with it through all configurations of a route, which is how
/// the truth about what moved is known.
struct SceneObject {
  std::uint16_t id = 0;        ///< Unique within the scene, at least 1; given by `Scene::Add`.
  std::uint16_t instance = 0;  ///< Value in instance images: the id, or 0 for what is no object.
  std::string name;            ///< For people, e.g. `outer-top-2-a`.
  std::string group;           ///< Things that touch and look like one share it; may be empty.
  SceneClass semantic_class = SceneClass::kBackground;
  Rgb color = {128, 128, 128};
  Shape shape;
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();  ///< Where `motion` is empty.
  std::vector<MotionKey> motion;  ///< Times rise; straight between keys, at rest outside them.

  /// Whether the object moves during a sequence.
  bool moves() const { return !motion.empty(); }

  /// Its pose `time_s` seconds after the start of the sequence.
  Eigen::Isometry3d PoseAt(double time_s) const;
};

/// One configuration of the world: everything there is during one sequence.
///
/// A value: scenarios copy a scene and change the copy.
class Scene {
 public:
  /// Adds an object, gives it the next id, and returns it for further settings. The reference
  /// holds until the next `Add` or `RemoveIf`. At most 65535 objects (asserted).
  SceneObject& Add(SceneObject object);

  /// Removes what `predicate(object)` selects. Ids are not given again.
  template <typename Predicate>
  void RemoveIf(Predicate predicate) {
    std::erase_if(objects_, predicate);
  }

  /// All objects, by rising id.
  const std::vector<SceneObject>& objects() const { return objects_; }

  std::vector<SceneObject>& objects() { return objects_; }

  /// The object with this id, or null.
  const SceneObject* Find(std::uint16_t id) const;

 private:
  std::vector<SceneObject> objects_;
  std::uint16_t last_id_ = 0;
};

/// What is true of the second of two configurations of one route and was not of the first.
struct SceneChange {
  std::vector<std::uint16_t> created;  ///< Ids, rising.
  std::vector<std::uint16_t> removed;  ///< Ids, rising.
  std::vector<std::uint16_t> moved;    ///< Ids, rising; the poses are in the two scenes.
};

/// Compares two configurations. An object that moves during a sequence is judged by its pose at
/// the start of it; a pose counts as another one beyond 1 mm or 0.1 degrees.
SceneChange CompareScenes(const Scene& before, const Scene& after);

/// A box that stands on the ground (z = 0), centred at (`x_m`, `y_m`), turned by `yaw_rad`. The
/// class is goods, the instance its id; change the returned object for anything else.
SceneObject& AddStandingBox(Scene* scene,
                            std::string_view name,
                            const Eigen::Vector3d& size_m,
                            const Eigen::Vector3d& x_y_yaw);

/// A floor at z = 0, centred at the origin; no instance.
SceneObject& AddFloor(Scene* scene, const Eigen::Vector2d& size_m);

}  // namespace steadymap

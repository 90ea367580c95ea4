#include "client/bench/simulator/scene/scene.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

namespace steadymap {
namespace {

constexpr double kSamePositionM = 1e-3;
constexpr double kSameAngleRad = 0.1 * M_PI / 180;

bool SamePose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(a.linear().transpose() * b.linear()));
  return (a.translation() - b.translation()).norm() <= kSamePositionM &&
         turn.angle() <= kSameAngleRad;
}

bool IdBelow(const SceneObject& object, std::uint16_t id) { return object.id < id; }

}  // namespace

Eigen::Isometry3d SceneObject::PoseAt(double time_s) const {
  if (motion.empty()) return T_world_object;
  const auto after =
      std::upper_bound(motion.begin(), motion.end(), time_s, [](double time, const MotionKey& key) {
        return time < key.time_s;
      });
  if (after == motion.begin()) return motion.front().T_world_object;
  if (after == motion.end()) return motion.back().T_world_object;
  const MotionKey& from = *(after - 1);
  const double share = (time_s - from.time_s) / (after->time_s - from.time_s);
  const Eigen::Quaterniond start(from.T_world_object.linear());
  const Eigen::Quaterniond end(after->T_world_object.linear());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = start.slerp(share, end).toRotationMatrix();
  pose.translation() =
      (1 - share) * from.T_world_object.translation() + share * after->T_world_object.translation();
  return pose;
}

SceneObject& Scene::Add(SceneObject object) {
  assert(last_id_ < std::numeric_limits<std::uint16_t>::max());
  object.id = ++last_id_;
  objects_.push_back(std::move(object));
  return objects_.back();
}

const SceneObject* Scene::Find(std::uint16_t id) const {
  const auto found = std::lower_bound(objects_.begin(), objects_.end(), id, IdBelow);
  return found != objects_.end() && found->id == id ? &*found : nullptr;
}

Eigen::AlignedBox3d BoxOf(const SceneObject& object) {
  Eigen::AlignedBox3d box_world;
  for (const Facet& facet : FacetsOf(object.shape, object.T_world_object)) {
    for (int i = 0; i < facet.vertex_count; ++i) {
      box_world.extend(facet.vertices[static_cast<std::size_t>(i)]);
    }
  }
  return box_world;
}

SceneChange CompareScenes(const Scene& before, const Scene& after) {
  SceneChange change;
  for (const SceneObject& object : before.objects()) {
    const SceneObject* later = after.Find(object.id);
    if (later == nullptr) {
      change.removed.push_back(object.id);
    } else if (!SamePose(object.PoseAt(0), later->PoseAt(0))) {
      change.moved.push_back(object.id);
    }
  }
  for (const SceneObject& object : after.objects()) {
    if (before.Find(object.id) == nullptr) change.created.push_back(object.id);
  }
  return change;
}

SceneObject& AddStandingBox(Scene* scene,
                            std::string_view name,
                            const Eigen::Vector3d& size_m,
                            const Eigen::Vector3d& x_y_yaw) {
  SceneObject object;
  object.name = name;
  object.semantic_class = SceneClass::kGoods;
  object.color = {176, 134, 84};
  object.shape = BoxShape{size_m};
  object.T_world_object.translation() = Eigen::Vector3d(x_y_yaw.x(), x_y_yaw.y(), size_m.z() / 2);
  object.T_world_object.linear() =
      Eigen::AngleAxisd(x_y_yaw.z(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  SceneObject& added = scene->Add(std::move(object));
  added.instance = added.id;
  return added;
}

SceneObject& AddFloor(Scene* scene, const Eigen::Vector2d& size_m) {
  SceneObject object;
  object.name = "floor";
  object.semantic_class = SceneClass::kGround;
  object.color = {118, 120, 122};
  object.shape = RectangleShape{size_m};
  return scene->Add(std::move(object));
}

}  // namespace steadymap

#include "client/bench/simulator/routes/box_room.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "client/bench/simulator/scene/furniture.h"
#include "client/dataset/layouts/torwic_layout.h"

namespace steadymap {
namespace {

constexpr double kCameraSpeedMPerS = 0.5;
constexpr double kLevelDistanceM = 2.0;  // From the camera to what it looks at.
constexpr double kPassLengthM = 3.0;
constexpr double kLookFrames = 3.0;
constexpr double kTargetHeightM = 0.25;  // Of what a camera that looks down looks at.
constexpr double kRoomTableHeightM = 0.7;

// A camera goes around from the left to the right, on the side away from the wall.
constexpr double kOrbitStartRad = -200.0 / 180.0 * M_PI;
constexpr double kOrbitEndRad = 20.0 / 180.0 * M_PI;

constexpr double kInViewPauseS = 0.2;

// Longer than what a robot may pause within one session.
constexpr double kStopS = 15.0;

const Eigen::Vector3d kBoxSizeM(0.5, 0.35, 0.45);
const Eigen::Vector3d kTallBoxSizeM(0.35, 0.3, 0.6);
const Eigen::Vector3d kLargeBoxSizeM(0.7, 0.5, 0.8);
const Eigen::Vector2d kPlace(-0.45, 0.0);
const Eigen::Vector2d kOtherPlace(0.55, 0.15);

/// A camera path along the places that it looks at.
class RoomCamera {
 public:
  RoomCamera(const BoxRoomSetting& setting, RoomPath path, std::vector<Eigen::Vector2d> targets)
      : height_m_(setting.camera_height_m),
        distance_m_(setting.looks_down ? setting.camera_height_m - kTargetHeightM
                                       : kLevelDistanceM),
        looks_down_(setting.looks_down),
        path_(path),
        targets_(std::move(targets)),
        leg_s_(DurationOf(path, distance_m_, setting.frame_period_s)) {}

  double duration_s() const { return leg_s_ * static_cast<double>(targets_.size()); }

  Eigen::Isometry3d PoseAt(double time_s) const {
    const double last = static_cast<double>(targets_.size()) - 1.0;
    const double leg = std::clamp(std::floor(time_s / leg_s_), 0.0, last);
    const double share = std::clamp(time_s / leg_s_ - leg, 0.0, 1.0);
    const Eigen::Vector2d& target = targets_[static_cast<std::size_t>(leg)];
    Eigen::Vector2d eye = target - distance_m_ * Eigen::Vector2d::UnitY();
    Eigen::Vector2d seen = target;
    if (path_ == RoomPath::kOrbit) {
      const double angle_rad = kOrbitStartRad + share * (kOrbitEndRad - kOrbitStartRad);
      eye = target + distance_m_ * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    } else if (path_ == RoomPath::kPass) {
      const Eigen::Vector2d offset((share - 0.5) * kPassLengthM, 0.0);
      eye += offset;
      seen += offset;
    }
    const double seen_m = looks_down_ ? height_m_ - distance_m_ : height_m_;
    return LookAt({eye.x(), eye.y(), height_m_}, {seen.x(), seen.y(), seen_m});
  }

 private:
  static double DurationOf(RoomPath path, double distance_m, double frame_period_s) {
    switch (path) {
      case RoomPath::kOrbit:
        return (kOrbitEndRad - kOrbitStartRad) * distance_m / kCameraSpeedMPerS;
      case RoomPath::kPass:
        return kPassLengthM / kCameraSpeedMPerS;
      case RoomPath::kLook:
        break;
    }
    return kLookFrames * frame_period_s;
  }

  double height_m_;
  double distance_m_;
  bool looks_down_;
  RoomPath path_;
  std::vector<Eigen::Vector2d> targets_;
  double leg_s_;
};

SceneObject& AddThing(Scene* scene, const Eigen::Vector3d& size_m, const Eigen::Vector2d& place) {
  return AddStandingBox(scene, "thing", size_m, {place.x(), place.y(), 0.0});
}

SceneObject& AddFurniture(Scene* scene,
                          std::string name,
                          SceneClass semantic_class,
                          Shape shape,
                          const Eigen::Vector3d& x_y_yaw) {
  SceneObject object;
  object.name = std::move(name);
  object.semantic_class = semantic_class;
  object.shape = std::move(shape);
  object.T_world_object = Eigen::Translation3d(x_y_yaw.x(), x_y_yaw.y(), 0.0) *
                          Eigen::AngleAxisd(x_y_yaw.z(), Eigen::Vector3d::UnitZ());
  SceneObject& added = scene->Add(std::move(object));
  added.instance = added.id;
  return added;
}

Scene MakeEmptyRoom() {
  Scene scene;
  AddFloor(&scene, {16.0, 9.0});
  SceneObject& wall = AddStandingBox(&scene, "wall", {14.0, 0.1, 2.5}, {1.0, 1.95, 0.0});
  wall.semantic_class = SceneClass::kWall;
  AddFurniture(&scene,
               "shelf",
               SceneClass::kRack,
               MakeShelfShape({0.35, 0.9, 1.1}, 4),
               {-2.3, 1.6, -M_PI / 2});
  AddFurniture(&scene,
               "table",
               SceneClass::kMachinery,
               MakeTableShape({1.1, 0.6, kRoomTableHeightM}),
               {2.2, 1.3, 0.0});
  AddStandingBox(&scene, "large-box", kLargeBoxSizeM, {-0.2, 1.3, 0.0});
  return scene;
}

bool IsWall(const SceneObject& object) { return object.semantic_class == SceneClass::kWall; }

bool IsJudged(const SceneObject& object) {
  return object.semantic_class != SceneClass::kGround && !IsWall(object);
}

bool IsAtBorder(const SceneObject& object) {
  return object.name == "shelf" || object.name == "table";
}

bool IsFurniture(const SceneObject& object) { return IsAtBorder(object) || object.name == "rack"; }

ClassId ClassOf(const SceneObject& object) {
  return ClassId(static_cast<std::uint16_t>(object.semantic_class));
}

void MoveTo(const Eigen::Vector2d& place, double yaw_rad, SceneObject* object) {
  object->T_world_object.translation().head<2>() = place;
  object->T_world_object.linear() =
      Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

/// The scenes of a case, in room coordinates, and what differs from one to the next.
class RoomStory {
 public:
  RoomStory() { scenes_.push_back(MakeEmptyRoom()); }

  Scene& first() { return scenes_.front(); }

  /// Starts a drive in which something changes.
  Scene& Next() { return scenes_.emplace_back(scenes_.back()); }

  Scene& Remove(std::uint16_t id) {
    Scene& scene = Next();
    scene.RemoveIf([id](const SceneObject& object) { return object.id == id; });
    return scene;
  }

  void Move(std::uint16_t id, const Eigen::Vector2d& place, double yaw_rad = 0.0) {
    for (SceneObject& object : Next().objects()) {
      if (object.id == id) MoveTo(place, yaw_rad, &object);
    }
  }

  void Swap(std::uint16_t a, std::uint16_t b) {
    Scene& scene = Next();
    for (SceneObject& object : scene.objects()) {
      if (object.id != a && object.id != b) continue;
      const SceneObject* other = scenes_[scenes_.size() - 2].Find(object.id == a ? b : a);
      MoveTo(other->T_world_object.translation().head<2>(), 0.0, &object);
    }
  }

  const std::vector<Scene>& scenes() const { return scenes_; }

  std::vector<Eigen::Vector2d> targets = {
      Eigen::Vector2d(0.0, 0.1)};             ///< Of all drives but the last.
  std::vector<Eigen::Vector2d> last_targets;  ///< Empty: like `targets`.
  double pause_s = 60.0;                      ///< Before the last drive.
  bool is_visible = true;                     ///< False: the change cannot be told.

 private:
  std::vector<Scene> scenes_;
};

void MoveFar(const Eigen::Vector2d& from, double distance_m, bool is_old_first, RoomStory* story) {
  const Eigen::Vector2d to = from + Eigen::Vector2d(distance_m, 0.0);
  const std::uint16_t thing = AddThing(&story->first(), kBoxSizeM, from).id;
  story->Move(thing, to);
  story->targets = {from, to};
  story->last_targets = is_old_first ? std::vector{from, to} : std::vector{to, from};
}

void RemoveNeighbour(double gap_m, RoomStory* story) {
  AddThing(&story->first(), kBoxSizeM, {-0.5 * (kBoxSizeM.x() + gap_m), 0.0});
  story->Remove(AddThing(&story->first(), kBoxSizeM, {0.5 * (kBoxSizeM.x() + gap_m), 0.0}).id);
}

void SwapThings(const Eigen::Vector3d& size_m, SceneClass semantic_class, RoomStory* story) {
  const std::uint16_t one = AddThing(&story->first(), kBoxSizeM, kPlace).id;
  SceneObject& other = AddThing(&story->first(), size_m, kOtherPlace);
  other.semantic_class = semantic_class;
  story->Swap(one, other.id);
}

std::uint16_t AddFirst(const Eigen::Vector3d& size_m,
                       const Eigen::Vector2d& place,
                       RoomStory* story) {
  return AddThing(&story->first(), size_m, place).id;
}

void MoveBy(double x_m, RoomStory* story) {
  const std::uint16_t thing = AddFirst(kBoxSizeM, kPlace, story);
  story->Move(thing, kPlace + Eigen::Vector2d(x_m, 0.0));
}

void TurnBy(double degrees, RoomStory* story) {
  const std::uint16_t thing = AddFirst(kBoxSizeM, kPlace, story);
  story->Move(thing, kPlace, degrees / 180.0 * M_PI);
}

void ChangeNothing(RoomStory* story) {
  AddFirst(kBoxSizeM, kPlace, story);
  AddFirst(kTallBoxSizeM, kOtherPlace, story);
  story->Next();
}

void RemoveOne(RoomStory* story) {
  AddFirst(kTallBoxSizeM, kOtherPlace, story);
  story->Remove(AddFirst(kBoxSizeM, kPlace, story));
}

void RemoveInView(RoomStory* story) {
  story->Remove(AddFirst(kBoxSizeM, kPlace, story));
  story->pause_s = kInViewPauseS;
}

void RemoveKnownInView(RoomStory* story) {
  const std::uint16_t thing = AddFirst(kBoxSizeM, kPlace, story);
  story->Next();
  story->Remove(thing);
  story->pause_s = kInViewPauseS;
}

void AddOne(RoomStory* story) {
  AddFirst(kTallBoxSizeM, kOtherPlace, story);
  AddThing(&story->Next(), kBoxSizeM, kPlace);
}

void SwapTwins(RoomStory* story) {
  SwapThings(kBoxSizeM, SceneClass::kGoods, story);
  story->is_visible = false;
}

void PutBack(RoomStory* story) {
  const std::uint16_t thing = AddFirst(kBoxSizeM, kPlace, story);
  const Scene before = story->first();
  story->Remove(thing);
  story->Next() = before;
}

void RemoveFromStack(bool is_upper, RoomStory* story) {
  const std::uint16_t lower = AddFirst(kBoxSizeM, kPlace, story);
  SceneObject& added = AddThing(&story->first(), {0.4, 0.3, 0.3}, kPlace);
  added.T_world_object.translation().z() += kBoxSizeM.z();
  const std::uint16_t upper = added.id;
  for (SceneObject& object : story->Remove(is_upper ? upper : lower).objects()) {
    if (object.id == upper) object.T_world_object.translation().z() -= kBoxSizeM.z();
  }
}

void RemoveFromWall(RoomStory* story) {
  story->Remove(AddFirst(kBoxSizeM, {0.8, 1.9 - 0.5 * kBoxSizeM.y()}, story));
}

void RemoveMug(RoomStory* story) {
  SceneObject& mug = AddFurniture(
      &story->first(), "mug", SceneClass::kGoods, MakeBarrelShape(0.045, 0.11), {2.0, 1.2, 0.0});
  mug.T_world_object.translation().z() = kRoomTableHeightM;
  story->Remove(mug.id);
  story->targets = {{2.0, 0.9}};
}

void RemoveRack(RoomStory* story) {
  SceneObject& rack = AddFurniture(&story->first(),
                                   "rack",
                                   SceneClass::kRack,
                                   MakeShelfShape({0.6, 1.4, 2.4}, 4),
                                   {1.0, 0.6, -M_PI / 2});
  story->Remove(rack.id);
}

/// A change with what happens in the room.
struct NamedStory {
  std::string_view name;
  void (*tell)(RoomStory* story);
};

// In the order of `RoomChange`.
constexpr NamedStory kStories[] = {
    {"nothing", ChangeNothing},
    {"removed", RemoveOne},
    {"removed-in-view", RemoveInView},
    {"added", AddOne},
    {"moved-5cm", [](RoomStory* story) { MoveBy(0.05, story); }},
    {"moved-10cm", [](RoomStory* story) { MoveBy(0.1, story); }},
    {"moved-30cm", [](RoomStory* story) { MoveBy(0.3, story); }},
    {"moved-1m-old-first", [](RoomStory* story) { MoveFar(kPlace, 1.0, true, story); }},
    {"moved-1m-new-first", [](RoomStory* story) { MoveFar(kPlace, 1.0, false, story); }},
    {"moved-5m-old-first", [](RoomStory* story) { MoveFar(kPlace, 5.0, true, story); }},
    {"moved-5m-new-first", [](RoomStory* story) { MoveFar(kPlace, 5.0, false, story); }},
    {"turned-15deg", [](RoomStory* story) { TurnBy(15.0, story); }},
    {"turned-45deg", [](RoomStory* story) { TurnBy(45.0, story); }},
    {"turned-90deg", [](RoomStory* story) { TurnBy(90.0, story); }},
    {"swapped-shapes",
     [](RoomStory* story) { SwapThings(kTallBoxSizeM, SceneClass::kGoods, story); }},
    {"swapped-classes",
     [](RoomStory* story) { SwapThings(kBoxSizeM, SceneClass::kNonStaticFeature, story); }},
    {"swapped-twins", SwapTwins},
    {"back-in-place", PutBack},
    {"touching-removed", [](RoomStory* story) { RemoveNeighbour(0.0, story); }},
    {"upper-removed", [](RoomStory* story) { RemoveFromStack(true, story); }},
    {"lower-removed", [](RoomStory* story) { RemoveFromStack(false, story); }},
    {"removed-from-wall", RemoveFromWall},
    {"mug-removed", RemoveMug},
    {"rack-removed", RemoveRack},
    {"neighbour-at-3cm-removed", [](RoomStory* story) { RemoveNeighbour(0.03, story); }},
    {"neighbour-at-8cm-removed", [](RoomStory* story) { RemoveNeighbour(0.08, story); }},
    {"neighbour-at-15cm-removed", [](RoomStory* story) { RemoveNeighbour(0.15, story); }},
    {"neighbour-at-30cm-removed", [](RoomStory* story) { RemoveNeighbour(0.3, story); }},
    {"known-removed-in-view", RemoveKnownInView},
};

RoomStory TellStory(RoomChange change) {
  RoomStory story;
  kStories[static_cast<std::size_t>(change)].tell(&story);
  if (story.last_targets.empty()) story.last_targets = story.targets;
  return story;
}

/// The events of the first drive are creations; an object that comes back returns.
void ListEvents(const std::vector<Scene>& scenes, bool is_visible, std::vector<RoomEvent>* events) {
  const auto add = [&](EventType type, const SceneObject& object) {
    if (!IsJudged(object)) return;
    events->push_back(
        {type, ClassOf(object), BoxOf(object), IsFurniture(object), !IsAtBorder(object)});
  };
  for (const SceneObject& object : scenes.front().objects()) add(EventType::kCreated, object);
  for (std::size_t i = 1; is_visible && i < scenes.size(); ++i) {
    const SceneChange change = CompareScenes(scenes[i - 1], scenes[i]);
    for (const std::uint16_t id : change.removed) {
      add(EventType::kRemoved, *scenes[i - 1].Find(id));
    }
    for (const std::uint16_t id : change.moved) add(EventType::kMoved, *scenes[i].Find(id));
    for (const std::uint16_t id : change.created) {
      const bool was_there = scenes.front().Find(id) != nullptr;
      add(was_there ? EventType::kReturned : EventType::kCreated, *scenes[i].Find(id));
    }
  }
}

/// Returns the transform from room coordinates, with the floor at z = 0, to the world frame.
Eigen::Isometry3d PlaceRoom(const BoxRoomSetting& setting) {
  return Eigen::Translation3d(0.0, 0.0, setting.floor_world_m) *
         Eigen::AngleAxisd(setting.slope_rad, Eigen::Vector3d::UnitX());
}

}  // namespace

std::vector<RoomChange> AllRoomChanges() {
  std::vector<RoomChange> changes;
  for (std::size_t i = 0; i < std::size(kStories); ++i) {
    changes.push_back(static_cast<RoomChange>(i));
  }
  return changes;
}

std::string_view NameOf(RoomChange change) {
  return kStories[static_cast<std::size_t>(change)].name;
}

BoxRoom MakeBoxRoom(RoomChange change, const BoxRoomSetting& setting) {
  const RoomStory story = TellStory(change);
  const Eigen::Isometry3d T_world_room = PlaceRoom(setting);
  std::vector<Scene> scenes = story.scenes();
  for (Scene& scene : scenes) {
    for (SceneObject& object : scene.objects()) {
      object.T_world_object = T_world_room * object.T_world_object;
    }
  }
  BoxRoom room;
  ListEvents(scenes, story.is_visible, &room.events);
  for (const SceneObject& object : scenes.back().objects()) {
    if (IsWall(object)) {
      room.wall_class = ClassOf(object);
      room.wall_world = BoxOf(object);
    }
    if (!IsJudged(object)) continue;
    room.objects.push_back(
        {ClassOf(object), BoxOf(object), IsFurniture(object), !IsAtBorder(object)});
  }
  room.route.name = NameOf(change);
  room.route.camera = DefaultTorwicCalibration().camera;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const bool is_last = i + 1 == scenes.size();
    const RoomCamera camera(setting,
                            is_last ? setting.path : RoomPath::kOrbit,
                            is_last ? story.last_targets : story.targets);
    Trajectory trajectory;
    // Between two frames, so that rounding cannot add one.
    trajectory.duration_s = camera.duration_s() - 0.5 * setting.frame_period_s;
    trajectory.frame_period_s = setting.frame_period_s;
    if (setting.stops && !(is_last && setting.path == RoomPath::kLook)) trajectory.stop_s = kStopS;
    trajectory.T_world_camera = [camera, T_world_room](double time_s) {
      return Eigen::Isometry3d(T_world_room * camera.PoseAt(time_s));
    };
    RouteSequence& sequence = room.route.sequences.emplace_back();
    sequence.name = "drive-" + std::to_string(i + 1);
    sequence.scene = std::move(scenes[i]);
    sequence.trajectory = std::move(trajectory);
    if (is_last) sequence.pause_s = story.pause_s;
  }
  return room;
}

}  // namespace steadymap

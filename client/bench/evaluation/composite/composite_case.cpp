#include "client/bench/evaluation/composite/composite_case.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <optional>
#include <utility>

#include "client/bench/evaluation/composite/frame_composer.h"
#include "client/bench/simulator/scene/counter_random.h"
#include "client/bench/simulator/scene/furniture.h"

namespace steadymap {
namespace {

constexpr int kTries = 3000;  // To find a place.

// A support is level, and within a centimetre or three of the base of the thing.
constexpr float kLevelCosine = 0.95F;
constexpr double kSupportM = 0.03;

// The base is divided into cells, almost all of which must have support.
constexpr std::size_t kBaseCells = 4;
constexpr std::size_t kMinSupported = 14;

constexpr double kClearanceM = 0.05;  // To the surface of the room.
constexpr double kApartM = 0.15;      // To other things.

// A thing is seen in so large a share of the views, with so many pixels.
constexpr double kMinSeenShare = 0.3;
constexpr std::size_t kMinSeenPixels = 600;

constexpr double kDegrees = M_PI / 180.0;

/// A shape whose base is at z = 0 of its frame, with its size.
struct Form {
  Shape shape;
  Eigen::Vector3d size_m;
};

Form BoxForm(const Eigen::Vector3d& size_m) {
  TriangleMesh mesh;
  AppendBox(size_m, {0.0, 0.0, 0.5 * size_m.z()}, &mesh);
  return {ShareMesh(std::move(mesh)), size_m};
}

std::vector<Form> Forms() {
  return {BoxForm({0.24, 0.16, 0.2}),
          BoxForm({0.16, 0.12, 0.28}),
          BoxForm({0.34, 0.2, 0.12}),
          {MakeCrateShape({0.3, 0.22, 0.15}), {0.3, 0.22, 0.15}},
          {MakeBarrelShape(0.09, 0.24), {0.18, 0.18, 0.24}},
          {MakeSackShape(0.12, 0.3), {0.24, 0.24, 0.3}}};
}

/// Position of the base, and heading.
struct Place {
  Eigen::Vector3d base_world;
  double yaw_rad = 0.0;

  Eigen::Isometry3d T_world_thing() const {
    return Eigen::Translation3d(base_world) * Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  }
};

/// The search for places of the things of one case.
class Placement {
 public:
  Placement(const RecordedRoom& room, std::uint64_t seed) : room_(room), seed_(seed) {}

  CompositeCase Run() {
    // A turn needs a shape that has a heading; the larger things are placed first.
    std::vector<std::pair<ThingChange, std::size_t>> changes = {{ThingChange::kMovedFar, 3},
                                                                {ThingChange::kTurned, 2},
                                                                {ThingChange::kMovedNear, 0},
                                                                {ThingChange::kRemoved, 5},
                                                                {ThingChange::kAdded, 1},
                                                                {ThingChange::kNone, 4}};
    // The other shapes change their roles from case to case.
    for (std::size_t i = changes.size(); i-- > 1;) {
      const std::size_t other =
          std::min(i, static_cast<std::size_t>(Draw(0.0, static_cast<double>(i + 1))));
      if (changes[i].first == ThingChange::kTurned || changes[other].first == ThingChange::kTurned)
        continue;
      std::swap(changes[i].second, changes[other].second);
    }
    for (const auto& [change, form] : changes) AddThing(change, forms_[form]);
    return std::move(case_);
  }

 private:
  double Draw(double low, double high) { return UniformBetween(seed_, draws_++, low, high); }

  void AddThing(ThingChange change, const Form& form) {
    const std::optional<Place> before = FindPlace(form, std::nullopt, ThingChange::kNone);
    if (!before) return;
    std::optional<Place> after = before;
    if (change == ThingChange::kMovedNear || change == ThingChange::kMovedFar ||
        change == ThingChange::kTurned) {
      after = FindPlace(form, before, change);
      if (!after) return;
    }
    taken_.emplace_back(before->base_world.head<2>(), RadiusOf(form));
    taken_.emplace_back(after->base_world.head<2>(), RadiusOf(form));
    SceneObject thing;
    thing.name = "thing";
    thing.semantic_class = SceneClass::kGoods;
    thing.shape = form.shape;
    // Both scenes give it the same id.
    const std::uint16_t id = Put(thing, *before, &case_.before);
    Put(thing, *after, &case_.after);
    const auto is_thing = [id](const SceneObject& object) { return object.id == id; };
    if (change == ThingChange::kAdded) case_.before.RemoveIf(is_thing);
    if (change == ThingChange::kRemoved) case_.after.RemoveIf(is_thing);
    case_.things.push_back({change, id});
  }

  static std::uint16_t Put(SceneObject thing, const Place& place, Scene* scene) {
    thing.T_world_object = place.T_world_thing();
    SceneObject& added = scene->Add(std::move(thing));
    added.instance = added.id;
    return added.id;
  }

  static double RadiusOf(const Form& form) { return 0.5 * form.size_m.head<2>().norm(); }

  std::optional<Place> FindPlace(const Form& form,
                                 const std::optional<Place>& before,
                                 ThingChange change) {
    for (int i = 0; i < kTries; ++i) {
      std::optional<Place> place = before ? DrawNewPlace(*before, change) : DrawPlace();
      if (place && IsApart(form, *place) && Stands(form, *place) && IsSeen(form, *place)) {
        return place;
      }
    }
    return std::nullopt;
  }

  std::optional<Place> DrawPlace() {
    const auto last = static_cast<double>(room_.surface.size());
    const auto index = static_cast<std::size_t>(Draw(0.0, last));
    const SurfacePoint& point = room_.surface[std::min(index, room_.surface.size() - 1)];
    if (point.normal_world.z() < kLevelCosine) return std::nullopt;
    return Place{point.position_world.cast<double>(), Draw(0.0, 2.0 * M_PI)};
  }

  std::optional<Place> DrawNewPlace(const Place& before, ThingChange change) {
    Place place = before;
    if (change == ThingChange::kTurned) {
      place.yaw_rad += Draw(30.0, 90.0) * kDegrees;
      return place;
    }
    const bool is_near = change == ThingChange::kMovedNear;
    const double distance_m = is_near ? Draw(0.1, 0.3) : Draw(0.3, 1.0);
    const double heading_rad = Draw(0.0, 2.0 * M_PI);
    place.base_world.x() += distance_m * std::cos(heading_rad);
    place.base_world.y() += distance_m * std::sin(heading_rad);
    return place;
  }

  bool IsApart(const Form& form, const Place& place) const {
    return std::all_of(taken_.begin(), taken_.end(), [&](const auto& taken) {
      return (taken.first - place.base_world.head<2>()).norm() >=
             taken.second + RadiusOf(form) + kApartM;
    });
  }

  /// Returns the cell of the base at a share of its side.
  static std::size_t CellAlong(double share) {
    const auto cell = static_cast<std::size_t>(share * static_cast<double>(kBaseCells));
    return std::min(cell, kBaseCells - 1);
  }

  /// True if a thing has support below it, and room around it.
  bool Stands(const Form& form, const Place& place) const {
    const Eigen::Isometry3d T_thing_world = place.T_world_thing().inverse();
    const Eigen::Vector2d half_m = 0.5 * form.size_m.head<2>();
    std::bitset<kBaseCells * kBaseCells> supported;
    for (const SurfacePoint& point : room_.surface) {
      const Eigen::Vector3d at = T_thing_world * point.position_world.cast<double>();
      const Eigen::Vector2d beyond_m = at.head<2>().cwiseAbs() - half_m;
      if (beyond_m.maxCoeff() > kClearanceM || at.z() > form.size_m.z() + kClearanceM) continue;
      if (at.z() > kSupportM) return false;
      if (at.z() < -kSupportM || beyond_m.maxCoeff() > 0.0 ||
          point.normal_world.z() < kLevelCosine) {
        continue;
      }
      const Eigen::Vector2d share = (at.head<2>() + half_m).cwiseQuotient(2.0 * half_m);
      supported.set(CellAlong(share.y()) * kBaseCells + CellAlong(share.x()));
    }
    return supported.count() >= kMinSupported;
  }

  bool IsSeen(const Form& form, const Place& place) const {
    Scene scene;
    SceneObject thing;
    thing.shape = form.shape;
    Put(thing, place, &scene);
    FrameComposer composer(&scene, room_.views.front().camera, room_.sensor);
    std::size_t seen = 0;
    for (const Frame& view : room_.views) {
      const Eigen::Vector3d at_camera = view.T_world_camera.inverse() * place.base_world;
      if (at_camera.z() > room_.max_depth_m) continue;
      if (composer.CountVisible(view) >= kMinSeenPixels) ++seen;
    }
    return static_cast<double>(seen) >= kMinSeenShare * static_cast<double>(room_.views.size());
  }

  const RecordedRoom& room_;
  std::uint64_t seed_;
  std::uint64_t draws_ = 0;
  std::vector<Form> forms_ = Forms();
  std::vector<std::pair<Eigen::Vector2d, double>> taken_;  ///< Centres and radii.
  CompositeCase case_;
};

}  // namespace

std::string_view NameOf(ThingChange change) {
  static constexpr std::string_view kNames[] = {
      "none", "moved-near", "moved-far", "turned", "removed", "added"};
  return kNames[static_cast<std::size_t>(change)];
}

CompositeCase MakeCompositeCase(const RecordedRoom& room, std::uint64_t seed) {
  return Placement(room, seed).Run();
}

}  // namespace steadymap

#include "client/bench/simulator/routes/clutter.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "client/bench/simulator/scene/counter_random.h"
#include "client/bench/simulator/scene/furniture.h"
#include "client/dataset/layouts/torwic_layout.h"

namespace steadymap {
namespace {

// Inner sides of the room, and the ellipse of the camera's path, concentric with the room.
constexpr double kRoomLengthM = 8.1;
constexpr double kRoomWidthM = 7.1;
constexpr double kWallHeightM = 2.4;
constexpr double kLapLengthM = 2.2;
constexpr double kLapWidthM = 1.8;
constexpr double kEyeHeightM = 1.2;
constexpr double kLapDurationS = 18.0;

constexpr int kLooseOnGround = 22;
constexpr int kLooseOnBoards = 16;
constexpr int kNewThings = 4;
constexpr int kTries = 60;

// Shares of the movable objects, between two sequences.
constexpr double kGoneShare = 0.12;
constexpr double kElsewhereShare = 0.12;
constexpr double kPushedShare = 0.15;

/// A supporting surface: the ground, a table top or a shelf board.
struct Board {
  Eigen::AlignedBox2d area_world;
  double height_m = 0.0;
};

/// A movable object, and the circle on its board that it occupies exclusively.
struct LooseThing {
  std::uint16_t id = 0;
  std::size_t board = 0;  ///< Index; 0 is the ground.
  Eigen::Vector2d center_world = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
};

/// First lap: the camera faces outwards; second lap: it faces the centre of the room.
Eigen::Isometry3d LookAround(double time_s) {
  const double angle_rad = 2 * M_PI * time_s / kLapDurationS;
  const Eigen::Vector3d eye(
      kLapLengthM * std::cos(angle_rad), kLapWidthM * std::sin(angle_rad), kEyeHeightM);
  if (time_s >= kLapDurationS) return LookAt(eye, {0, 0, 0.5});
  const double ahead_rad = angle_rad + 0.5;
  return LookAt(eye, {4 * std::cos(ahead_rad), 4 * std::sin(ahead_rad), 0.5});
}

/// True if an object of this radius blocks the camera's path.
bool IsInTheWay(const Eigen::Vector2d& center_world, double radius_m) {
  const double lap = std::hypot(center_world.x() / kLapLengthM, center_world.y() / kLapWidthM);
  return std::abs(lap - 1.0) * kLapWidthM < radius_m + 0.3;
}

class ClutterRoom {
 public:
  explicit ClutterRoom(std::uint64_t seed) : key_(seed) {
    AddRoom();
    AddFurniture();
    for (int i = 0; i < kLooseOnGround; ++i) AddLoose(/*is_small=*/false);
    for (int i = 0; i < kLooseOnBoards; ++i) AddLoose(/*is_small=*/true);
  }

  const Scene& scene() const { return scene_; }

  /// Rearranges the movable objects between two sequences.
  void Rearrange() {
    const std::vector<LooseThing> before = loose_;
    for (const LooseThing& thing : before) {
      const double fate = Uniform(0, 1);
      std::optional<LooseThing> after;
      if (fate < kGoneShare) {
        Forget(thing.id);
        scene_.RemoveIf([&](const SceneObject& object) { return object.id == thing.id; });
      } else if (fate < kGoneShare + kElsewhereShare) {
        after = FindPlace(thing);
      } else if (fate < kGoneShare + kElsewhereShare + kPushedShare) {
        after = FindPlaceNear(thing);
      }
      if (after) Put(*after);
    }
    for (int i = 0; i < kNewThings; ++i) AddLoose(i % 2 == 0);
  }

 private:
  double Uniform(double low, double high) { return UniformBetween(key_, drawn_++, low, high); }

  void AddRoom() {
    AddFloor(&scene_, {kRoomLengthM, kRoomWidthM});
    boards_.push_back({CenteredArea({0, 0}, {kRoomLengthM, kRoomWidthM}), 0.0});
    constexpr double kThicknessM = 0.1;
    for (const double side : {-0.5, 0.5}) {
      AddStandingBox(&scene_,
                     "wall",
                     {kRoomLengthM, kThicknessM, kWallHeightM},
                     {0, side * (kRoomWidthM + kThicknessM), 0});
      AddStandingBox(&scene_,
                     "wall",
                     {kThicknessM, kRoomWidthM, kWallHeightM},
                     {side * (kRoomLengthM + kThicknessM), 0, 0});
    }
    for (SceneObject& object : scene_.objects()) {
      if (object.name != "wall") continue;
      object.semantic_class = SceneClass::kWall;
      object.instance = 0;
      object.color = {206, 202, 190};
    }
  }

  void AddFurniture() {
    AddTable({1.6, 0.9, 0.75}, {0, 0});
    AddTable({1.4, 0.7, 0.72}, {Uniform(-1.5, 1.5), kRoomWidthM / 2 - 0.4});
    AddTable({0.7, 1.4, 0.72}, {kRoomLengthM / 2 - 0.4, Uniform(-1.2, 1.2)});
    const Eigen::Vector3d shelf_m(0.4, 1.2, 1.8);
    for (const double x_m : {Uniform(-2.8, -1.0), Uniform(1.0, 2.8)}) {
      AddShelf(shelf_m, {x_m, -kRoomWidthM / 2 + shelf_m.x() / 2 + 0.02}, M_PI / 2);
    }
    AddShelf(shelf_m, {-kRoomLengthM / 2 + shelf_m.x() / 2 + 0.02, Uniform(-1.5, 1.5)}, 0);
  }

  void AddTable(const Eigen::Vector3d& size_m, const Eigen::Vector2d& center_world) {
    SceneObject table;
    table.name = absl::StrCat("table-", boards_.size());
    table.semantic_class = SceneClass::kMachinery;
    table.color = {150, 120, 92};
    table.shape = MakeTableShape(size_m);
    Stand(&table, center_world, 0, Uniform(-0.05, 0.05));
    AddFixed(std::move(table));
    boards_.push_back({CenteredArea(center_world, size_m.head<2>()), size_m.z()});
    furniture_.push_back(boards_.back().area_world);
  }

  void AddShelf(const Eigen::Vector3d& size_m,
                const Eigen::Vector2d& center_world,
                double yaw_rad) {
    constexpr int kBoards = 4;
    SceneObject shelf;
    shelf.name = absl::StrCat("shelf-", boards_.size());
    shelf.semantic_class = SceneClass::kRack;
    shelf.color = {92, 104, 120};
    shelf.shape = MakeShelfShape(size_m, kBoards);
    Stand(&shelf, center_world, 0, yaw_rad);
    AddFixed(std::move(shelf));
    const Eigen::Vector2d footprint_m = yaw_rad == 0 ? Eigen::Vector2d(size_m.x(), size_m.y())
                                                     : Eigen::Vector2d(size_m.y(), size_m.x());
    furniture_.push_back(CenteredArea(center_world, footprint_m));
    // The lowest board is hardly visible and stays empty.
    for (int board = 1; board < kBoards; ++board) {
      boards_.push_back({furniture_.back(), ShelfBoardHeight(size_m.z(), kBoards, board)});
    }
  }

  void AddFixed(SceneObject object) {
    SceneObject& added = scene_.Add(std::move(object));
    added.instance = added.id;
  }

  /// Generates an object and places it, if there is space.
  void AddLoose(bool is_small) {
    SceneObject object;
    LooseThing thing;
    thing.board = is_small ? 1 : 0;
    thing.radius_m = DrawThing(is_small, &object);
    const std::optional<LooseThing> placed = FindPlace(thing);
    if (!placed) return;
    object.name = absl::StrCat(object.name, "-", scene_.objects().size());
    SceneObject& added = scene_.Add(std::move(object));
    added.instance = added.id;
    LooseThing loose = *placed;
    loose.id = added.id;
    Put(loose);
  }

  /// Returns the radius of the object's footprint.
  double DrawThing(bool is_small, SceneObject* object) {
    const auto tone = static_cast<std::uint8_t>(Uniform(110, 220));
    object->color = {tone, static_cast<std::uint8_t>(Uniform(80, 200)), 90};
    object->semantic_class = SceneClass::kGoods;
    const double scale = is_small ? 0.5 : 1.0;
    switch (static_cast<int>(Uniform(0, is_small ? 4 : 6))) {
      case 0: {
        const Eigen::Vector3d size_m =
            scale * Eigen::Vector3d(Uniform(0.3, 0.5), Uniform(0.3, 0.6), Uniform(0.3, 0.8));
        object->name = "box";
        TriangleMesh mesh;
        AppendBox(size_m, {0, 0, size_m.z() / 2}, &mesh);
        object->shape = ShareMesh(std::move(mesh));
        return size_m.head<2>().norm() / 2;
      }
      case 1: {
        const Eigen::Vector3d size_m =
            scale * Eigen::Vector3d(Uniform(0.35, 0.45), Uniform(0.45, 0.65), Uniform(0.3, 0.4));
        object->name = "crate";
        object->shape = MakeCrateShape(size_m);
        return size_m.head<2>().norm() / 2;
      }
      case 2: {
        const double radius_m = scale * Uniform(0.18, 0.28);
        object->name = "barrel";
        object->shape = MakeBarrelShape(radius_m, scale * Uniform(0.5, 0.9));
        return radius_m;
      }
      case 3: {
        const double radius_m = scale * Uniform(0.2, 0.3);
        object->name = "sack";
        object->shape = MakeSackShape(radius_m, scale * Uniform(0.5, 0.7));
        return radius_m;
      }
      case 4:
        object->name = "chair";
        object->semantic_class = SceneClass::kNonStaticFeature;
        object->shape = MakeChairShape();
        return 0.32;
      default:
        object->name = "plant";
        object->semantic_class = SceneClass::kNonStaticFeature;
        object->shape = MakePlantShape(Uniform(0.9, 1.3));
        return 0.25;
    }
  }

  /// Returns a free place for an object: on the ground if it was there before, else on any other
  /// board.
  std::optional<LooseThing> FindPlace(LooseThing thing) {
    const bool was_on_ground = thing.board == 0;
    for (int i = 0; i < kTries; ++i) {
      if (!was_on_ground) {
        thing.board =
            1 + static_cast<std::size_t>(Uniform(0, static_cast<double>(boards_.size() - 1)));
      }
      const Board& board = boards_[thing.board];
      const Eigen::Vector2d low = board.area_world.min();
      const Eigen::Vector2d high = board.area_world.max();
      thing.center_world = {Uniform(low.x(), high.x()), Uniform(low.y(), high.y())};
      // Every second attempt places it against a neighbour.
      if (i % 2 == 0) LeanOnNeighbour(&thing);
      if (IsFree(thing)) return thing;
    }
    return std::nullopt;
  }

  std::optional<LooseThing> FindPlaceNear(LooseThing thing) {
    const Eigen::Vector2d from_world = thing.center_world;
    for (int i = 0; i < kTries; ++i) {
      const double way_m = Uniform(0.1, 0.4);
      const double heading_rad = Uniform(0, 2 * M_PI);
      thing.center_world =
          from_world + way_m * Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
      if (IsFree(thing)) return thing;
    }
    return std::nullopt;
  }

  /// Moves an object so that its circle touches the circle of another object on the same board.
  void LeanOnNeighbour(LooseThing* thing) {
    if (loose_.empty()) return;
    const LooseThing& other =
        loose_[static_cast<std::size_t>(Uniform(0, static_cast<double>(loose_.size())))];
    if (other.board != thing->board || other.id == thing->id) return;
    const Eigen::Vector2d away = (thing->center_world - other.center_world).normalized();
    thing->center_world = other.center_world + (other.radius_m + thing->radius_m + 0.002) * away;
  }

  bool IsFree(const LooseThing& thing) const {
    const Eigen::AlignedBox2d& area = boards_[thing.board].area_world;
    // An object may protrude slightly over the edge of a board.
    const double inside_m = thing.board == 0 ? thing.radius_m : 0.6 * thing.radius_m;
    if (((thing.center_world - area.min()).array() < inside_m).any() ||
        ((area.max() - thing.center_world).array() < inside_m).any()) {
      return false;
    }
    if (thing.board == 0) {
      if (IsInTheWay(thing.center_world, thing.radius_m)) return false;
      for (const Eigen::AlignedBox2d& footprint : furniture_) {
        if (footprint.exteriorDistance(thing.center_world) < thing.radius_m) return false;
      }
    }
    return std::all_of(loose_.begin(), loose_.end(), [&](const LooseThing& other) {
      return other.id == thing.id || other.board != thing.board ||
             (other.center_world - thing.center_world).norm() >= other.radius_m + thing.radius_m;
    });
  }

  void Put(const LooseThing& thing) {
    for (SceneObject& object : scene_.objects()) {
      if (object.id != thing.id) continue;
      Stand(&object, thing.center_world, boards_[thing.board].height_m, Uniform(-M_PI, M_PI));
    }
    Forget(thing.id);
    loose_.push_back(thing);
  }

  void Forget(std::uint16_t id) {
    std::erase_if(loose_, [id](const LooseThing& thing) { return thing.id == id; });
  }

  static void Stand(SceneObject* object,
                    const Eigen::Vector2d& center_world,
                    double height_m,
                    double yaw_rad) {
    object->T_world_object = Eigen::Isometry3d::Identity();
    object->T_world_object.translate(Eigen::Vector3d(center_world.x(), center_world.y(), height_m));
    object->T_world_object.rotate(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
  }

  static Eigen::AlignedBox2d CenteredArea(const Eigen::Vector2d& center_world,
                                          const Eigen::Vector2d& size_m) {
    return {Eigen::Vector2d(center_world - size_m / 2), Eigen::Vector2d(center_world + size_m / 2)};
  }

  const std::uint64_t key_;
  std::uint64_t drawn_ = 0;
  Scene scene_;
  std::vector<Board> boards_;
  std::vector<Eigen::AlignedBox2d> furniture_;  ///< Footprints on the ground.
  std::vector<LooseThing> loose_;
};

}  // namespace

Route MakeClutterRoute(std::uint64_t seed) {
  Route route;
  route.name = seed == 1 ? "clutter" : absl::StrCat("clutter-", seed);
  route.camera = DefaultTorwicCalibration().camera;
  Trajectory trajectory;
  trajectory.duration_s = 2 * kLapDurationS;
  trajectory.T_world_camera = LookAround;
  ClutterRoom room(seed);
  for (const char* name : {"first", "second", "third"}) {
    route.sequences.push_back({name, room.scene(), trajectory});
    room.Rearrange();
  }
  return route;
}

}  // namespace steadymap

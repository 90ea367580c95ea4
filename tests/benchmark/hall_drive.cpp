#include "tests/benchmark/hall_drive.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <utility>
#include <variant>

#include "client/bench/simulator/routes/large_hall.h"
#include "client/bench/simulator/simulation.h"
#include "tests/support/analytic_map.h"

namespace steadymap::benchmarks {
namespace {

constexpr std::size_t kAisles = 20;
constexpr std::size_t kNearbyObjects = 43;

// Number of frames at 1.4 m/s that show `kNearbyObjects` within the integrated depth.
constexpr std::size_t kFramesOneWay = 27;
constexpr int kWays = 5;

constexpr std::int64_t kFramePeriodNs = 100'000'000;

// Objects were mapped one after the other, farther apart than the duration of one visit.
constexpr double kSecondsBetweenObjects = 60.0;

constexpr double kMaxDepthM = 3.0;

/// Counts the pixels of each instance within `kMaxDepthM`.
void CountPixels(const Frame& frame, std::map<std::uint16_t, std::size_t>* pixels) {
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      const std::uint16_t depth = frame.depth.units.At(u, v);
      if (depth == kNoDepth || depth * frame.depth.metres_per_unit > kMaxDepthM) continue;
      if (const std::uint16_t id = frame.instances.At(u, v); id != 0) ++(*pixels)[id];
    }
  }
}

/// Returns the ids with the most pixels, at most `kNearbyObjects`.
std::vector<std::uint16_t> MostShown(const std::map<std::uint16_t, std::size_t>& pixels) {
  std::vector<std::pair<std::size_t, std::uint16_t>> by_count;
  by_count.reserve(pixels.size());
  for (const auto& [id, count] : pixels) by_count.emplace_back(count, id);
  std::sort(by_count.rbegin(), by_count.rend());
  std::vector<std::uint16_t> ids;
  for (const auto& [count, id] : by_count) {
    if (ids.size() < kNearbyObjects) ids.push_back(id);
  }
  return ids;
}

/// Repeats the frames, reversed every second time, with increasing capture times.
std::vector<Frame> ToAndFro(std::vector<Frame> there) {
  std::vector<Frame> frames;
  const Timestamp start = there.front().capture_time;
  for (int way = 0; way < kWays; ++way) {
    std::copy(there.begin(), there.end(), std::back_inserter(frames));
    std::reverse(there.begin(), there.end());
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].capture_time = Timestamp::FromNanoseconds(
        start.nanoseconds() + static_cast<std::int64_t>(i) * kFramePeriodNs);
  }
  return frames;
}

/// Returns a box of the scene as a map object that was observed from all sides.
MapObject Known(const SceneObject& thing, Timestamp now, const VoxelScale& scale) {
  const auto& box = std::get<BoxShape>(thing.shape);
  MapObject object = testing::BoxObject(
      ObjectId(thing.id), box.size_m, {thing.T_world_object.translation(), 0.0}, scale);
  object.class_id = ClassId(static_cast<std::uint16_t>(thing.semantic_class));
  object.votes = {{object.class_id, 100.0}};
  object.belief.alpha = 9.0;
  object.supporting_frames = 100;
  object.first_seen = now - Duration::FromSeconds(kSecondsBetweenObjects * thing.id);
  object.in_place_since = object.first_seen;
  object.last_seen = object.first_seen;
  return object;
}

bool IsObject(const SceneObject& thing) {
  return thing.instance != 0 && thing.semantic_class != SceneClass::kWall &&
         std::holds_alternative<BoxShape>(thing.shape);
}

}  // namespace

HallDrive MakeHallDrive(const VoxelScale& scale) {
  LargeHallOptions hall;
  hall.aisles = static_cast<int>(kAisles);
  SimulationOptions options;
  options.include_instances = true;
  Simulation simulation(MakeLargeHallRoute(hall).value(), options);

  std::vector<Frame> there;
  std::map<std::uint16_t, std::size_t> pixels;
  // The middle of the path is the end of an aisle; half an aisle later the racks are on both sides.
  const std::size_t first = simulation.frame_count() * (kAisles + 1) / (2 * kAisles);
  for (std::size_t i = first; i < first + kFramesOneWay; ++i) {
    Frame& frame = there.emplace_back(simulation.Render(i));
    CountPixels(frame, &pixels);
    frame.instances = {};
  }

  const std::vector<std::uint16_t> shown = MostShown(pixels);
  const Timestamp start = there.front().capture_time;
  HallDrive drive{ToAndFro(std::move(there)), MapSnapshot(scale), MapSnapshot(scale)};
  for (const SceneObject& thing : simulation.route().sequences.front().scene.objects()) {
    if (!IsObject(thing)) continue;
    testing::AddObject(Known(thing, start, scale), &drive.whole);
    const ObjectId id(thing.id);
    drive.whole.newest_object = id;
    if (std::find(shown.begin(), shown.end(), thing.id) == shown.end()) continue;
    drive.nearby.objects.insert_or_assign(id, drive.whole.objects.at(id));
  }
  drive.nearby.newest_object = drive.whole.newest_object;
  return drive;
}

}  // namespace steadymap::benchmarks

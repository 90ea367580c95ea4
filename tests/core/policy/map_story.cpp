#include "tests/core/policy/map_story.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/map/map_delta.h"
#include "core/volume/tsdf_codec.h"
#include "core/volume/tsdf_mesh.h"

namespace steadymap::testing {
namespace {

constexpr double kStorySecondsPerFrame = 0.5;
constexpr double kSecondsBetweenVisits = 60.0;

}  // namespace

SceneBody FarWall() { return Body(kWallClass, {2.6, -4.0, -3.0}, {3.0, 4.0, 3.0}); }

SceneBody Goods(double y, double x) {
  return Body(kGoodsClass, {x, y - 0.25, -0.3}, {x + 0.4, y + 0.25, 0.3});
}

Box Around(const SceneBody& body, double margin_m) {
  return {body.box_world.min().array() - margin_m, body.box_world.max().array() + margin_m};
}

MapConfig ConfigOf(UpdatePolicy policy) {
  MapConfig config;
  config.policy = policy;
  return config;
}

MapConfig PocdConfig() { return ConfigOf(UpdatePolicy::kPocd); }

MapConfig FinePocdConfig() {
  MapConfig config = PocdConfig();
  config.voxel_size_m = 0.02;
  config.truncation_m = 0.06;
  return config;
}

std::vector<Frame> LookAtScene(const Scene& scene, int first, int count, int visit) {
  std::vector<Frame> frames;
  for (int i = first; i < first + count; ++i) {
    frames.push_back(RenderScene(
        scene,
        {.eye_world = {0.0, 0.4 * std::sin(0.7 * i), 0.1},
         .target_world = {2.0, 0.1, 0.0},
         .capture_time_s = 100.0 + kStorySecondsPerFrame * i + kSecondsBetweenVisits * visit}));
  }
  return frames;
}

Frame SmallFrame(int width_px, int height_px, double depth_m, double capture_time_s) {
  Frame frame;
  frame.capture_time = Timestamp::FromSeconds(capture_time_s);
  frame.camera = {width_px, height_px, 40.0, 40.0, 0.5 * width_px, 0.5 * height_px};
  frame.depth.units = Image<std::uint16_t>(
      width_px, height_px, static_cast<std::uint16_t>(std::lround(1000.0 * depth_m)));
  frame.labels = Image<std::uint16_t>(width_px, height_px, kGoodsClass);
  return frame;
}

MapStory::MapStory(const MapConfig& config, StageObserver* stages)
    : config_(config),
      stages_(stages),
      mapper_(Mapper::Create(config, stages).value()),
      told_(VoxelScale{config.voxel_size_m, config.truncation_m}) {}

void MapStory::Play(const std::vector<Frame>& frames, std::size_t frames_per_commit) {
  for (const Frame& frame : frames) {
    mapper_->Integrate(mapper_->head().Next(), frame);
    last_source_ = frame.source;
    if (mapper_->uncommitted_entries() == frames_per_commit) Commit();
  }
  Commit();
}

void MapStory::Look(const Scene& scene, int count, int visit) {
  Play(LookAtScene(scene, static_cast<int>(mapper_->head().value()), count, visit));
}

void MapStory::EndSession() { EndSession(last_source_); }

void MapStory::EndSession(const SensorName& sensor) {
  mapper_->EndSession(mapper_->head().Next(), sensor);
  Commit();
}

void MapStory::Restart() {
  mapper_ = Mapper::Create(config_, stages_).value();
  mapper_->Restore(told_);
}

std::vector<ObjectEvent> MapStory::EventsOf(EventType type,
                                            std::uint16_t label,
                                            Revision after) const {
  std::vector<ObjectEvent> found;
  for (const ObjectEvent& event : events_) {
    if (event.type == type && event.class_id == ClassId(label) && event.revision > after) {
      found.push_back(event);
    }
  }
  return found;
}

std::vector<std::shared_ptr<const MapObject>> MapStory::Present(std::uint16_t label) const {
  std::vector<std::shared_ptr<const MapObject>> found;
  for (const auto& [id, object] : map_->objects) {
    if (object->status == ObjectStatus::kPresent && object->class_id == ClassId(label)) {
      found.push_back(object);
    }
  }
  return found;
}

void MapStory::Commit() {
  const MapCommit commit = mapper_->Commit();
  map_ = commit.snapshot;
  events_.insert(events_.end(), commit.delta.events.begin(), commit.delta.events.end());
  ASSERT_TRUE(Apply(commit.delta, &told_).ok());
  for (const ObjectEvent& event : commit.delta.events) Replay(event);
  std::set<ObjectId> present;
  for (const auto& [id, object] : map_->objects) {
    if (object->status == ObjectStatus::kPresent) present.insert(id);
  }
  EXPECT_EQ(present_by_events_, present) << "at revision " << map_->revision.value();
}

void MapStory::Replay(const ObjectEvent& event) {
  switch (event.type) {
    case EventType::kCreated:
    case EventType::kReturned:
    case EventType::kSplit:
      EXPECT_TRUE(present_by_events_.insert(event.object).second) << event.object.value();
      break;
    case EventType::kMoved:
      EXPECT_TRUE(present_by_events_.contains(event.object) || event.related != kBackgroundId);
      present_by_events_.insert(event.object);
      present_by_events_.erase(event.related);
      break;
    case EventType::kRemoved:
    case EventType::kMerged:
      // A part that was no object of its own is not present.
      EXPECT_EQ(present_by_events_.erase(event.object),
                event.type == EventType::kRemoved && event.related != kBackgroundId ? 0U : 1U)
          << event.object.value();
      break;
    case EventType::kUpdated:
    case EventType::kRobotLost:
    case EventType::kRobotFound:
    case EventType::kContradicted:
      break;
  }
}

std::map<LeafKey, std::string> PackedLeaves(const MapSnapshot& map) {
  std::map<LeafKey, std::string> packed;
  map.background.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    packed[{kBackgroundId, origin}] = PackLeaf(leaf);
  });
  for (const auto& [id, object] : map.objects) {
    object->volume->ForEachLeaf([&, key = id](LeafOrigin origin, const LeafView& leaf) {
      packed[{key, origin}] = PackLeaf(leaf);
    });
  }
  return packed;
}

void ExpectSameMap(const MapSnapshot& a, const MapSnapshot& b) {
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.last_capture_time, b.last_capture_time);
  EXPECT_EQ(a.newest_object, b.newest_object);
  EXPECT_TRUE(PackedLeaves(a) == PackedLeaves(b));
  EXPECT_TRUE(a.free_space == b.free_space);
  EXPECT_TRUE(a.robots == b.robots);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (const auto& [id, object] : a.objects) {
    ASSERT_TRUE(b.objects.contains(id)) << id.value();
    const ObjectState& state = *object;
    const ObjectState& other = *b.objects.at(id);
    EXPECT_TRUE(state == other) << id.value();
  }
}

std::size_t CountSurfaceIn(const MapSnapshot& map, const Box& box_world) {
  std::size_t count = 0;
  const auto count_in = [&](const VoxelReader& volume, const Eigen::Isometry3f& T_world_volume) {
    for (const Eigen::Vector3f& vertex : ExtractMesh(volume, map.scale, nullptr).vertices_world) {
      const Eigen::Vector3f vertex_world = T_world_volume * vertex;
      if (box_world.contains(vertex_world.cast<double>())) ++count;
    }
  };
  count_in(map.background, Eigen::Isometry3f::Identity());
  for (const auto& [id, object] : map.objects) {
    if (object->status != ObjectStatus::kPresent) continue;
    count_in(*object->volume, object->T_world_object.ToIsometry().cast<float>());
  }
  return count;
}

}  // namespace steadymap::testing

#include "tests/server/store/store_builder.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "core/volume/tsdf_codec.h"

namespace steadymap {
namespace {

constexpr VoxelScale kScale{0.04, 0.12};

}  // namespace

MapRecord MakeMapRecord(const std::string& tenant, const std::string& map) {
  MapRecord record;
  record.name = {tenant, map};
  record.display_name = "The hall \"2\"\n";
  record.config.policy = UpdatePolicy::kPocd;
  record.config.voxel_size_m = kScale.voxel_size_m;
  record.config.truncation_m = kScale.truncation_m;
  record.config.max_depth_m = 4.25;
  record.config.parameters = {{"change_noise_m", 0.125}, {"max_evidence", 20.0}};
  record.config.classes = {{ClassId{3}, "wall", ClassMotion::kStatic},
                           {ClassId{7}, "cart", ClassMotion::kSemiStatic},
                           {ClassId{9}, "person", ClassMotion::kDynamic}};
  record.frame_log_age = std::chrono::seconds(3600);
  record.frame_log_bytes = 1 << 30;
  record.byte_budget = 123'456'789;
  record.max_commit_delay = std::chrono::milliseconds(40);
  record.create_time = Timestamp::FromNanoseconds(1'700'000'000'123'456'789);
  record.incarnation = "incarnation-1";
  record.request_id = "request-1";
  record.change_request_id = "request-2";
  record.labels = {{"site", "north"}, {"shift", ""}};
  record.world_frame = {"at the gate", "2", GeoAnchor{48.1, 11.5, 519.0, 90.0}};
  record.version = 5;
  return record;
}

LogEntry MakeLogEntry(std::uint64_t sequence, std::size_t bytes) {
  std::mt19937_64 random(sequence);
  LogEntry entry;
  entry.sequence = MapSequence{sequence};
  entry.source = {"robot-" + std::to_string(sequence % 3), "camera"};
  entry.packed_frame.resize(bytes);
  for (char& byte : entry.packed_frame) byte = static_cast<char>(random());
  return entry;
}

FramePose MakePose(std::uint64_t sequence) {
  FramePose pose;
  pose.sequence = MapSequence{sequence};
  pose.source = MakeLogEntry(sequence, 0).source;
  pose.capture_time = Timestamp::FromNanoseconds(static_cast<std::int64_t>(sequence) * 33'333'333);
  pose.T_world_camera = Eigen::Translation3d(0.1 * static_cast<double>(sequence), -2.0, 1.0 / 3.0) *
                        Eigen::AngleAxisd(0.01 * static_cast<double>(sequence),
                                          Eigen::Vector3d(1, 2, 3).normalized());
  return pose;
}

LogAppend MakeAppend(MapKey map, std::uint64_t first, std::uint64_t count, MapUptime uptime) {
  LogAppend append{map, uptime, {}, {}};
  for (std::uint64_t i = 0; i < count; ++i) append.entries.push_back(MakeLogEntry(first + i));
  append.sessions.push_back(MakeSession("session-1", first + count - 1, uptime));
  return append;
}

SessionRecord MakeSession(const std::string& session,
                          std::uint64_t settled,
                          MapUptime last_active) {
  SessionRecord record;
  record.name = {kStoreSensor, session};
  record.settled.InsertThrough(ClientSequence{settled});
  record.last_map_seq = MapSequence{settled};
  record.last_active = last_active;
  record.last_active_time = Timestamp::FromSeconds(2e9);
  return record;
}

CommitDetails MakeDetails(const MapDelta& delta, MapUptime uptime) {
  CommitDetails details;
  for (std::uint64_t i = delta.from.value() + 1; i <= delta.to.value(); ++i) {
    details.poses.push_back(MakePose(i));
  }
  details.uptime = uptime;
  return details;
}

LeafChange MakeLeaf(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed) {
  std::mt19937 random(seed);
  LeafVoxels voxels;
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    if (random() % 3 == 0) continue;
    voxels.observed.at(offset >> 6) |= std::uint64_t{1} << (offset & 63);
    const int steps = static_cast<int>(random() % (2 * kMaxDistanceSteps + 1)) - kMaxDistanceSteps;
    voxels.voxels.at(offset) = Voxel(steps, 1 + static_cast<int>(random() % 5000));
  }
  return {{kBackgroundId, {x * kLeafSide, y * kLeafSide, z * kLeafSide}}, PackLeaf(ViewOf(voxels))};
}

ObjectState MakeObject(std::uint64_t id, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-100.0, 100.0);
  const auto vector = [&] {
    return Eigen::Vector3d(number(random), number(random), number(random));
  };
  ObjectState state;
  state.id = ObjectId{id};
  state.status = static_cast<ObjectStatus>(random() % 3);
  state.revision = Revision{random()};
  state.class_id = ClassId{static_cast<std::uint16_t>(random())};
  state.votes = {{ClassId{3}, number(random)}, {ClassId{9}, number(random)}};
  state.T_world_object = {vector(), number(random)};
  state.cuboid = {vector(), vector().cwiseAbs(), number(random)};
  state.belief = {number(random), 0.01 + std::abs(number(random)), 1.0 / 3.0, 2.0 / 7.0};
  state.evidence.present_cells = number(random);
  state.evidence.absent_cells = number(random);
  for (std::int32_t x = -2; x < 3; ++x) {
    LeafEvidence& leaf = state.evidence.MutableLeaf({x * kLeafSide, -x * kLeafSide, 0});
    for (std::int8_t& score : leaf.score) score = static_cast<std::int8_t>(random());
    leaf.last_look = Timestamp::FromNanoseconds(static_cast<std::int64_t>(random()));
  }
  state.evidence.leaves.back().score = {};
  for (const char* robot : {"robot-1", "robot-2"}) {
    state.looks.push_back({{robot, "camera"}, state.evidence.leaves});
    state.looks.back().leaves.resize(2);
  }
  state.parts = {{ObjectId{2}, static_cast<std::uint32_t>(random()), 1}, {ObjectId{7}, 0, 3, 2}};
  for (std::int32_t x = -1; x < 2; ++x) {
    const auto frames = static_cast<std::uint32_t>(random());
    state.gaps.push_back({.cell = {x, -2, 9},
                          .frames = frames | 1,
                          .weight = 0.01 + std::abs(number(random)),
                          .width_m = std::abs(number(random)),
                          .middle_world = vector(),
                          .view_sum_world = {number(random), number(random)}});
  }
  state.source = {"robot-" + std::to_string(random() % 9), "left"};
  state.contradictions = {{{"robot-2", "camera"},
                           {"robot-1", "camera"},
                           Timestamp::FromNanoseconds(static_cast<std::int64_t>(random())),
                           Timestamp::FromNanoseconds(static_cast<std::int64_t>(random())),
                           static_cast<std::uint32_t>(random())}};
  state.first_seen = Timestamp::FromNanoseconds(-static_cast<std::int64_t>(random()));
  state.in_place_since = Timestamp::FromNanoseconds(static_cast<std::int64_t>(random()));
  state.last_seen = Timestamp::FromNanoseconds(static_cast<std::int64_t>(random()));
  state.has_given_extent = true;
  state.supporting_frames = random();
  state.contradicted_updates = random();
  return state;
}

ObjectEvent MakeEvent(EventType type, std::uint64_t object, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-100.0, 100.0);
  const auto vector = [&] {
    return Eigen::Vector3d(number(random), number(random), number(random));
  };
  ObjectEvent event;
  event.type = type;
  event.reason = EventReason::kShapeMatched;
  event.object = ObjectId{object};
  event.class_id = ClassId{7};
  event.time = Timestamp::FromNanoseconds(static_cast<std::int64_t>(random()));
  event.revision = Revision{random()};
  event.center_world = vector();
  if (type == EventType::kMoved) {
    event.old_center_world = vector();
    event.move = {{vector(), number(random)}, {vector(), number(random)}};
    event.confidence = 1.0 / 3.0;
  }
  event.before = {number(random), 0.5, 1.0 / 3.0, 4.0};
  event.after = {number(random), 0.5, 2.0 / 3.0, 5.0};
  event.related = ObjectId{random()};
  event.supporting_frames = random();
  event.contradicted_updates = random();
  if (type == EventType::kRobotLost || type == EventType::kRobotFound ||
      type == EventType::kContradicted) {
    event.source = kStoreSensor;
  }
  return event;
}

RobotState MakeRobot(Trust trust, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-100.0, 100.0);
  const auto vector = [&] {
    return Eigen::Vector3d(number(random), number(random), number(random));
  };
  RobotState state;
  state.trust = trust;
  state.last_capture_time = Timestamp::FromNanoseconds(-static_cast<std::int64_t>(random()));
  state.claimed = {vector(), vector().cast<float>()};
  state.likely = state.claimed;
  if (trust != Trust::kTrusted) {
    state.claimed_log_odds = static_cast<float>(number(random));
    state.likely_log_odds = static_cast<float>(number(random));
    state.likely = {vector(), vector().cast<float>()};
  }
  if (trust != Trust::kTrusted) {
    PoseOffset offset{state.last_capture_time, vector(), vector(), number(random)};
    const Eigen::Matrix4d root = Eigen::Matrix4d::NullaryExpr([&] { return number(random); });
    offset.covariance = root.selfadjointView<Eigen::Upper>();
    offset.anchors = 1 + seed;
    state.offset = offset;
    PoseErrorEstimate estimate{state.last_capture_time, {}};
    for (PoseErrorHypothesis& hypothesis : estimate.hypotheses) {
      hypothesis.error.mean << vector(), vector();
      hypothesis.error.covariance.diagonal().setConstant(200.0);
      hypothesis.error.covariance(0, 5) = hypothesis.error.covariance(5, 0) = number(random);
      hypothesis.probability = 1.0 / kPoseErrorHypotheses;
    }
    state.pose_error = estimate;
  }
  if (trust != Trust::kLost) {
    state.velocity_m_per_s = vector().cast<float>();
    state.turn_rad_per_s = vector().cast<float>();
    state.moving = {{{-40, 3, 0}, state.last_capture_time, false},
                    {{-40, 3, 1}, state.last_capture_time, true},
                    {{static_cast<std::int32_t>(seed), -7, 2}, Timestamp(), true}};
  }
  return state;
}

MapDelta MakeDelta(std::uint64_t from, std::uint64_t to, std::vector<LeafChange> leaves) {
  std::sort(leaves.begin(), leaves.end(), [](const LeafChange& a, const LeafChange& b) {
    return a.key < b.key;
  });
  return {
      .from = Revision{from},
      .to = Revision{to},
      .last_capture_time = Timestamp::FromNanoseconds(static_cast<std::int64_t>(to) * 1'000'003),
      .leaves = std::move(leaves)};
}

std::vector<LeafChange> LeavesOf(const MapSnapshot& snapshot) {
  std::vector<LeafChange> leaves;
  const auto append = [&](ObjectId id, const VoxelReader& volume) {
    volume.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
      leaves.push_back({{id, origin}, PackLeaf(leaf)});
    });
  };
  append(kBackgroundId, snapshot.background);
  for (const auto& [id, object] : snapshot.objects) append(id, *object->volume);
  std::sort(leaves.begin(), leaves.end(), [](const LeafChange& a, const LeafChange& b) {
    return a.key < b.key;
  });
  return leaves;
}

bool SameEntry(const LogEntry& a, const LogEntry& b) {
  return a.sequence == b.sequence && a.kind == b.kind && a.source == b.source &&
         a.packed_frame == b.packed_frame && a.classes == b.classes;
}

std::vector<LogEntry> ReadAll(Store* store, MapKey map, std::uint64_t first) {
  std::vector<LogEntry> entries;
  const absl::Status status = store->ReadLog(map, MapSequence{first}, [&](LogEntry entry) {
    entries.push_back(std::move(entry));
    return absl::OkStatus();
  });
  EXPECT_TRUE(status.ok()) << status;
  return entries;
}

}  // namespace steadymap

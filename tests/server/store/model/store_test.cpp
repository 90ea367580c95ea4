// Tests the contract of Store with the RocksDB store and with its in-memory substitute.

#include "server/store/model/store.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "core/types/map_config.h"
#include "tests/server/store/store_contract.h"
#include "tests/support/thread_limit.h"

namespace steadymap {
namespace {

INSTANTIATE_TEST_SUITE_P(Stores,
                         StoreContract,
                         ::testing::Values(StoreKind::kRocks, StoreKind::kMemory),
                         NameOfStore);

TEST_P(StoreContract, MapRecordSurvivesARestartFieldByField) {
  const MapRecord created = Create("hall");
  Reopen();
  const std::vector<MapRecord> maps = store_->ListMaps().value();
  ASSERT_EQ(maps.size(), 1U);
  const MapRecord& map = maps.front();
  const MapRecord expected = MakeMapRecord("acme", "hall");
  EXPECT_EQ(map.key, created.key);
  EXPECT_EQ(map.name, expected.name);
  EXPECT_EQ(map.display_name, expected.display_name);
  EXPECT_EQ(map.config, expected.config);
  EXPECT_EQ(map.frame_log_age, expected.frame_log_age);
  EXPECT_EQ(map.frame_log_bytes, expected.frame_log_bytes);
  EXPECT_EQ(map.byte_budget, expected.byte_budget);
  EXPECT_EQ(map.max_commit_delay, expected.max_commit_delay);
  EXPECT_EQ(map.create_time, expected.create_time);
  EXPECT_EQ(map.incarnation, expected.incarnation);
  EXPECT_EQ(map.request_id, expected.request_id);
  EXPECT_EQ(map.version, expected.version);
  EXPECT_TRUE(map.condition.ok());
}

TEST_P(StoreContract, OpensAMapWhoseParametersAnEarlierVersionKnew) {
  if (GetParam() == StoreKind::kMemory) GTEST_SKIP() << "does not outlive the version";
  MapRecord record = MakeMapRecord("acme", "hall");
  record.config.parameters = {
      {"change_noise_m", -1.0}, {"max_evidence", 20.0}, {"removed_in_a_later_version", 3.0}};
  ASSERT_TRUE(store_->CreateMap(record).ok());
  Reopen();
  const MapRecord map = store_->ListMaps().value().front();
  EXPECT_TRUE(map.condition.ok());
  EXPECT_TRUE(ValidateMapConfig(map.config).ok());
  record.config.parameters = {{"max_evidence", 20.0}};
  EXPECT_EQ(map.config, record.config);
}

TEST_P(StoreContract, ListsMapsInTheOrderOfTheirNames) {
  for (const char* name : {"hall-2", "b", "hall", "a"}) Create(name);
  ASSERT_TRUE(store_->CreateMap(MakeMapRecord("acme-2", "a")).ok());
  ASSERT_TRUE(store_->CreateMap(MakeMapRecord("ac", "z")).ok());
  Reopen();
  std::vector<std::string> names;
  const absl::StatusOr<std::vector<MapRecord>> maps = store_->ListMaps();
  for (const MapRecord& map : *maps) names.push_back(map.name.ToString());
  EXPECT_EQ(names,
            (std::vector<std::string>{"tenants/ac/maps/z",
                                      "tenants/acme/maps/a",
                                      "tenants/acme/maps/b",
                                      "tenants/acme/maps/hall",
                                      "tenants/acme/maps/hall-2",
                                      "tenants/acme-2/maps/a"}));
}

TEST_P(StoreContract, RefusesASecondMapOfTheSameName) {
  Create("hall");
  const absl::Status status = store_->CreateMap(MakeMapRecord("acme", "hall")).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(ReasonOf(status), reason::kAlreadyExists);
}

TEST_P(StoreContract, RefusesANameThatIsNoId) {
  EXPECT_EQ(ReasonOf(store_->CreateMap(MakeMapRecord("acme", "../x")).status()), reason::kBadName);
  EXPECT_EQ(ReasonOf(store_->CreateMap(MakeMapRecord("", "x")).status()), reason::kBadName);
}

TEST_P(StoreContract, UpdateReplacesTheRecordAndSurvivesARestart) {
  MapRecord map = Create("hall");
  map.display_name = "Another";
  map.frame_log_age = std::chrono::seconds(7);
  map.version = 6;
  ASSERT_TRUE(store_->UpdateMap(map).ok());
  Reopen();
  const MapRecord again = store_->ListMaps().value().front();
  EXPECT_EQ(again.display_name, "Another");
  EXPECT_EQ(again.frame_log_age, std::chrono::seconds(7));
  EXPECT_EQ(again.version, 6U);
}

TEST_P(StoreContract, UpdateNeverChangesNameOrConfig) {
  MapRecord map = Create("hall");
  map.name.map = "other";
  EXPECT_EQ(store_->UpdateMap(map).code(), absl::StatusCode::kFailedPrecondition);
  map = store_->ListMaps().value().front();
  map.config.voxel_size_m = 0.1;
  EXPECT_EQ(store_->UpdateMap(map).code(), absl::StatusCode::kFailedPrecondition);
}

TEST_P(StoreContract, UnknownMapsAreNotFound) {
  MapRecord nobody = MakeMapRecord("acme", "nobody");
  nobody.key = MapKey{99};
  const auto visit = [](const LogEntry&) { return absl::OkStatus(); };
  for (const absl::Status& status :
       {store_->UpdateMap(nobody),
        store_->DeleteMap(nobody.key),
        store_->LoadMap(nobody).status(),
        store_->Append(MakeAppend(nobody.key, 1, 1)),
        TryCommit(nobody.key, MakeDelta(0, 1, {})),
        store_->ReadLog(nobody.key, MapSequence{1}, visit),
        store_->ReadPoses(nobody.key, MapSequence{1}, MapSequence{9}, 9).status(),
        store_->ReadEvents(nobody.key, EventNumber{1}, 9).status(),
        store_->health(nobody.key),
        store_->Trim(nobody, {kStoreTime, kForgetNone})}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kNotFound) << status;
    EXPECT_EQ(ReasonOf(status), reason::kNotFound);
  }
}

TEST_P(StoreContract, NewMapIsEmpty) {
  const MapRecord map = Create("hall");
  Reopen();
  const StoredState state = Load(map);
  EXPECT_EQ(state.snapshot.revision, Revision{0});
  EXPECT_EQ(state.snapshot.last_capture_time, Timestamp());
  EXPECT_EQ(state.snapshot.scale, (VoxelScale{0.04, 0.12}));
  EXPECT_TRUE(state.snapshot.objects.empty());
  EXPECT_EQ(state.snapshot.free_space, FreeSpace(0.08));
  EXPECT_EQ(state.snapshot.background.leaf_count(), 0U);
  EXPECT_EQ(state.durable_head, MapSequence{0});
  EXPECT_TRUE(state.sessions.empty());
  EXPECT_TRUE(ReadAll(store_.get(), map.key).empty());
}

TEST_P(StoreContract, EntriesPosesAndSessionsSurviveARestartBitForBit) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 20));
  LogAppend second{map.key, kStoreTime, {}, {}};
  second.entries.push_back(MakeLogEntry(21, 300'000));
  second.entries.push_back(MakeLogEntry(22, 0));
  second.sessions.push_back(MakeSession("session-2", 5));
  second.sessions.back().settled.InsertThrough(ClientSequence{9});
  Append(second);
  Commit(map.key, MakeDelta(0, 21, {}));
  Reopen();
  const std::vector<LogEntry> entries = ReadAll(store_.get(), map.key);
  ASSERT_EQ(entries.size(), 22U);
  for (std::uint64_t i = 0; i < 20; ++i) {
    EXPECT_TRUE(SameEntry(entries[i], MakeLogEntry(i + 1))) << i;
  }
  EXPECT_TRUE(SameEntry(entries[20], second.entries[0]));
  EXPECT_TRUE(SameEntry(entries[21], second.entries[1]));
  const StoredState state = Load(map);
  EXPECT_EQ(state.durable_head, MapSequence{22});
  ASSERT_EQ(state.sessions.size(), 2U);
  EXPECT_EQ(state.sessions[0].name, (SessionName{kStoreSensor, "session-1"}));
  EXPECT_EQ(state.sessions[0].settled, MakeSession("session-1", 20).settled);
  EXPECT_EQ(state.sessions[0].last_map_seq, MapSequence{20});
  EXPECT_EQ(state.sessions[0].last_active, kStoreTime);
  EXPECT_EQ(state.sessions[0].last_active_time, Timestamp::FromSeconds(2e9));
  EXPECT_EQ(state.sessions[1].settled.contiguous_end(), ClientSequence{9});
  const std::vector<FramePose> poses =
      store_->ReadPoses(map.key, MapSequence{20}, MapSequence{22}, 10).value();
  ASSERT_EQ(poses.size(), 2U) << "the last frame is not integrated";
  EXPECT_EQ(poses[0].sequence, MapSequence{20});
  EXPECT_EQ(poses[0].source, MakePose(20).source);
  EXPECT_EQ(poses[0].capture_time, MakePose(20).capture_time);
  EXPECT_EQ(poses[0].T_world_camera.matrix(), MakePose(20).T_world_camera.matrix());
}

TEST_P(StoreContract, ClassesThatAreAddedSurviveARestart) {
  const MapRecord map = Create("hall");
  const std::vector<SemanticClass> first = {{ClassId{20}, "tugger", ClassMotion::kDynamic, false}};
  const std::vector<SemanticClass> second = {{ClassId{21}, "kerb", ClassMotion::kStatic, true}};
  LogAppend append = MakeAppend(map.key, 1, 3);
  for (const std::size_t place : {0U, 2U}) {
    LogEntry& entry = append.entries[place];
    entry.kind = LogEntryKind::kClasses;
    entry.source = {};
    entry.packed_frame.clear();
    entry.classes = place == 0 ? first : second;
  }
  Append(append);
  MapDelta delta = MakeDelta(0, 2, {});
  delta.added_classes = first;
  Commit(map.key, delta);
  for (int restart = 0; restart < 2; ++restart) {
    const StoredState state = Load(map);
    EXPECT_EQ(state.snapshot.added_classes, first) << "the second entry is not integrated";
    std::vector<SemanticClass> durable = map.config.classes;
    durable.insert(durable.end(), first.begin(), first.end());
    durable.insert(durable.end(), second.begin(), second.end());
    EXPECT_EQ(state.durable_classes, durable);
    EXPECT_TRUE(SameEntry(ReadAll(store_.get(), map.key).at(2), append.entries[2]));
    Reopen();
  }
}

TEST_P(StoreContract, ReadLogStartsWhereAskedAndStopsAtTheVisitorsError) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 10));
  EXPECT_EQ(ReadAll(store_.get(), map.key, 8).size(), 3U);
  EXPECT_TRUE(ReadAll(store_.get(), map.key, 11).empty());
  int visited = 0;
  const absl::Status status = store_->ReadLog(map.key, MapSequence{1}, [&](const LogEntry&) {
    return ++visited == 4 ? absl::CancelledError("enough") : absl::OkStatus();
  });
  EXPECT_EQ(status, absl::CancelledError("enough"));
  EXPECT_EQ(visited, 4);
}

TEST_P(StoreContract, ReadPosesKeepsToItsLimit) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 10));
  Commit(map.key, MakeDelta(0, 10, {}));
  const auto count = [&](std::uint64_t first, std::uint64_t last, std::size_t limit) {
    return store_->ReadPoses(map.key, MapSequence{first}, MapSequence{last}, limit)->size();
  };
  EXPECT_EQ(count(1, std::numeric_limits<std::uint64_t>::max(), 4), 4U);
  EXPECT_EQ(count(1, 3, 100), 3U);
  EXPECT_EQ(count(1, 3, 0), 0U);
  EXPECT_EQ(count(5, 4, 100), 0U);
}

TEST_P(StoreContract, RefusesEntriesThatDoNotFollowTheHeadAndTakesNothing) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 2));
  LogAppend with_gap = MakeAppend(map.key, 3, 3);
  with_gap.entries.erase(with_gap.entries.begin() + 1);
  for (const LogAppend& append : {MakeAppend(map.key, 2, 1), MakeAppend(map.key, 4, 1), with_gap}) {
    EXPECT_EQ(store_->Append(append).code(), absl::StatusCode::kFailedPrecondition);
  }
  Reopen();
  EXPECT_EQ(ReadAll(store_.get(), map.key).size(), 2U);
  EXPECT_EQ(Load(map).durable_head, MapSequence{2});
  EXPECT_EQ(Load(map).sessions.front().settled.contiguous_end(), ClientSequence{2});
}

TEST_P(StoreContract, AppendWithoutEntriesStoresItsSessions) {
  const MapRecord map = Create("hall");
  Append({map.key, kStoreTime, {}, {MakeSession("session-1", 3)}});
  Append({map.key, kStoreTime, {}, {}});
  Reopen();
  EXPECT_EQ(Load(map).sessions.size(), 1U);
  EXPECT_EQ(Load(map).durable_head, MapSequence{0});
}

TEST_P(StoreContract, RefusesASessionWithoutAnIdAndTakesNothing) {
  const MapRecord map = Create("hall");
  LogAppend append = MakeAppend(map.key, 1, 1);
  append.sessions.front().name.sensor.robot = std::string("a\0b", 3);
  EXPECT_EQ(ReasonOf(store_->Append(append)), reason::kBadName);
  EXPECT_TRUE(ReadAll(store_.get(), map.key).empty());
}

TEST_P(StoreContract, CommitsSurviveARestartLeafByLeaf) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 40));
  Commit(map.key, MakeDelta(0, 32, {MakeLeaf(0, 0, 0, 1), MakeLeaf(-1, 5, -300, 2)}));
  Commit(map.key, MakeDelta(32, 40, {MakeLeaf(0, 0, 0, 3), MakeLeaf(100'000, -100'000, 7, 4)}));
  Reopen();
  const StoredState state = Load(map);
  EXPECT_EQ(state.snapshot.revision, Revision{40});
  EXPECT_EQ(state.snapshot.last_capture_time, MakeDelta(32, 40, {}).last_capture_time);
  const MapDelta expected = MakeDelta(
      0, 40, {MakeLeaf(0, 0, 0, 3), MakeLeaf(-1, 5, -300, 2), MakeLeaf(100'000, -100'000, 7, 4)});
  EXPECT_EQ(LeavesOf(state.snapshot), expected.leaves);
}

TEST_P(StoreContract, LoadsTheSameOnAnyNumberOfThreads) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 1));
  constexpr std::int32_t kLeaves = 1300;
  std::vector<LeafChange> leaves;
  leaves.reserve(kLeaves);
  for (std::int32_t i = 0; i < kLeaves; ++i) {
    leaves.push_back(MakeLeaf(i % 40, i / 40, -i % 7, static_cast<std::uint32_t>(i)));
  }
  const MapDelta delta = MakeDelta(0, 1, std::move(leaves));
  Commit(map.key, delta);
  Reopen();
  for (const int threads : {1, 2, 8}) {
    const StoredState state = testing::RunOnThreads(threads, [&] { return Load(map); });
    EXPECT_EQ(LeavesOf(state.snapshot), delta.leaves) << threads << " threads";
  }
}

TEST_P(StoreContract, CommitOfAnEmptyLeafRemovesIt) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 2));
  Commit(map.key, MakeDelta(0, 1, {MakeLeaf(0, 0, 0, 1), MakeLeaf(1, 0, 0, 2)}));
  LeafChange gone = MakeLeaf(0, 0, 0, 1);
  gone.packed.clear();
  Commit(map.key, MakeDelta(1, 2, {gone}));
  Reopen();
  EXPECT_EQ(LeavesOf(Load(map).snapshot), std::vector<LeafChange>{MakeLeaf(1, 0, 0, 2)});
}

TEST_P(StoreContract, RefusesACommitThatDoesNotFollowTheRevision) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 4));
  Commit(map.key, MakeDelta(0, 2, {MakeLeaf(0, 0, 0, 1)}));
  for (const auto& [from, to] : {std::pair{0, 3}, {3, 4}, {2, 1}, {2, 5}}) {
    const MapDelta delta = MakeDelta(
        static_cast<std::uint64_t>(from), static_cast<std::uint64_t>(to), {MakeLeaf(9, 9, 9, 2)});
    EXPECT_EQ(TryCommit(map.key, delta).code(), absl::StatusCode::kFailedPrecondition)
        << from << " to " << to;
  }
  Commit(map.key, MakeDelta(2, 2, {}));
  EXPECT_EQ(Load(map).snapshot.revision, Revision{2});
  EXPECT_EQ(Load(map).snapshot.background.leaf_count(), 1U);
}

TEST_P(StoreContract, DeleteLeavesNothingAndTouchesNoOtherMap) {
  const MapRecord first = Create("first");
  const MapRecord second = Create("second");
  for (const MapRecord& map : {first, second}) {
    Append(MakeAppend(map.key, 1, 3));
    Commit(map.key, MakeDelta(0, 3, {MakeLeaf(0, 0, 0, 1)}));
  }
  ASSERT_TRUE(store_->DeleteMap(first.key).ok());
  const MapRecord again = Create("first");
  EXPECT_GT(again.key, second.key) << "a key must never be used twice";
  Reopen();
  EXPECT_EQ(store_->LoadMap(first).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(Load(again).durable_head, MapSequence{0});
  EXPECT_EQ(Load(again).snapshot.background.leaf_count(), 0U);
  EXPECT_TRUE(Load(again).sessions.empty());
  EXPECT_EQ(ReadAll(store_.get(), second.key).size(), 3U);
  EXPECT_EQ(Load(second).snapshot.background.leaf_count(), 1U);
}

TEST_P(StoreContract, KeysOfDeletedMapsAreNotReusedAfterARestart) {
  const MapRecord first = Create("first");
  ASSERT_TRUE(store_->DeleteMap(first.key).ok());
  Reopen();
  EXPECT_GT(Create("first").key, first.key);
}

TEST_P(StoreContract, SessionOfAMillionFramesStaysOneInterval) {
  const MapRecord map = Create("hall");
  SessionRecord session = MakeSession("long", 0);
  for (std::uint64_t value = 1; value <= 1'000'000; ++value) {
    ASSERT_TRUE(session.settled.Insert(ClientSequence{value}).ok());
  }
  Append({map.key, kStoreTime, {}, {session}});
  Reopen();
  EXPECT_EQ(Load(map).sessions.front().settled.interval_count(), 1U);
  EXPECT_EQ(Load(map).sessions.front().settled.contiguous_end(), ClientSequence{1'000'000});
}

TEST_P(StoreContract, MapThatIsNotOpenTakesNothing) {
  const MapRecord map = Create("hall");
  if (GetParam() == StoreKind::kMemory) GTEST_SKIP() << "is always open";
  store_.reset();
  store_ = Store::Open(folder_.path() / "data", options_).value();
  EXPECT_EQ(store_->Append(MakeAppend(map.key, 1, 1)).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->health(map.key).code(), absl::StatusCode::kNotFound);
  Load(map);
  EXPECT_TRUE(store_->health(map.key).ok());
  Append(MakeAppend(map.key, 1, 1));
}

TEST_P(StoreContract, CommitMarksTellHistoriesApart) {
  const MapRecord first = Create("first");
  const MapRecord second = Create("second");
  for (const MapRecord& map : {first, second}) Append(MakeAppend(map.key, 1, 4));
  const auto commit = [this](const MapRecord& map, std::uint64_t to, std::uint32_t seed) {
    return Commit(map.key, MakeDelta(to - 1, to, {MakeLeaf(0, 0, 0, seed)}));
  };
  EXPECT_EQ(commit(first, 1, 1), commit(second, 1, 1));
  EXPECT_NE(commit(first, 2, 2).hash, commit(second, 2, 3).hash);
  const CommitMark mark = commit(first, 3, 4);
  EXPECT_NE(mark.hash, commit(second, 3, 4).hash) << "what differed once differs for ever";
  Reopen();
  EXPECT_EQ(Load(first).commit, mark);
}

TEST_P(StoreContract, WritersOfSeveralMapsAndReadersRunAtOnce) {
  constexpr std::uint64_t kFrames = 60;
  const std::vector<MapRecord> maps = {Create("a"), Create("b"), Create("c")};
  std::vector<std::thread> threads;
  for (const MapRecord& map : maps) {
    threads.emplace_back([&, map] {
      for (std::uint64_t i = 1; i <= kFrames; ++i) {
        EXPECT_TRUE(store_->Append(MakeAppend(map.key, i, 1)).ok());
        if (i % 20 != 0) continue;
        const MapDelta delta =
            MakeDelta(i - 20, i, {MakeLeaf(0, 0, 0, static_cast<std::uint32_t>(i))});
        EXPECT_TRUE(TryCommit(map.key, delta).ok());
      }
    });
    threads.emplace_back([&, map] {
      for (int i = 0; i < 20; ++i) {
        const absl::StatusOr<StoredState> state = store_->LoadMap(map);
        ASSERT_TRUE(state.ok()) << state.status();
        EXPECT_LE(state->snapshot.revision.value(), state->durable_head.value());
        EXPECT_GE(ReadAll(store_.get(), map.key).size(), state->durable_head.value());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const MapRecord& map : maps) {
    EXPECT_EQ(Load(map).durable_head, MapSequence{kFrames});
    EXPECT_EQ(LeavesOf(Load(map).snapshot), std::vector<LeafChange>{MakeLeaf(0, 0, 0, kFrames)});
  }
}

}  // namespace
}  // namespace steadymap

// Tests that faults planted in a correct watch are detected, each under its promise's name.

#include "tests/watch/watch_promises.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <grpcpp/impl/codegen/proto_utils.h>
#include <gtest/gtest.h>

#include "server/watch/watch_hub.h"
#include "tests/server/store/store_builder.h"
#include "tests/server/watch/recording_watch.h"
#include "tests/support/memory_store.h"

namespace steadymap {
namespace {

using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::StartsWith;

using Messages = std::vector<v1::WatchMapResponse>;
using Kind = v1::WatchMapResponse;

constexpr VoxelScale kTinyScale{0.04, 0.12};

/// Three commits: an object and much background are added, the object changes, and is removed.
class PlantedFaults : public ::testing::Test {
 protected:
  void SetUp() override {
    record_ = store_.CreateMap(MakeMapRecord("acme", "hall")).value();
    ASSERT_TRUE(store_.Append(MakeAppend(record_.key, 1, 30)).ok());
    std::vector<LeafChange> leaves;
    leaves.reserve(41);
    for (int i = 0; i < 40; ++i) leaves.push_back(MakeLeaf(i, 0, 0, static_cast<std::uint32_t>(i)));
    LeafChange owned = MakeLeaf(3, 0, 0, 77);
    owned.key.object = ObjectId(5);
    leaves.push_back(owned);
    Commit(10, leaves, MakeCrate(ObjectStatus::kPresent), 2);
    leaves = {MakeLeaf(1, 0, 0, 500)};
    Commit(20, leaves, MakeCrate(ObjectStatus::kPresent), 1);
    Commit(30, {}, MakeCrate(ObjectStatus::kArchived), 1);
  }

  static ObjectState MakeCrate(ObjectStatus standing) {
    ObjectState crate = MakeObject(5, 1);
    crate.status = standing;
    return crate;
  }

  void Commit(std::uint64_t to,
              std::vector<LeafChange> leaves,
              const ObjectState& crate,
              int events) {
    MapDelta delta = MakeDelta(map_.revision.value(), to, std::move(leaves));
    delta.last_capture_time = Timestamp::FromSeconds(100.0);
    delta.objects = {{crate.id, crate}};
    for (int i = 0; i < events; ++i) {
      ObjectEvent event = MakeEvent(EventType::kUpdated, 5, 3);
      event.revision = Revision(to);
      delta.events.push_back(event);
    }
    delta.last_event = EventNumber(map_.last_event.value() + delta.events.size());
    const absl::StatusOr<CommitMark> mark =
        store_.CommitRevision(record_.key, delta, {.uptime = MapUptime(1)});
    ASSERT_TRUE(mark.ok()) << mark.status();
    ASSERT_TRUE(Apply(delta, &map_).ok());
    history_.Add(delta);
    published_.push_back({std::make_shared<const MapSnapshot>(map_), *mark, {}});
  }

  /// Returns the messages of a correct server: the first revision as a snapshot, then two steps.
  Messages HonestMessages() {
    WatchHub hub({&store_, 10, absl::InfiniteDuration()});
    EXPECT_TRUE(hub.Enter(record_.key, std::make_shared<RecordingWatch>()).ok());
    Messages messages;
    messages.emplace_back().mutable_created()->set_revision(10);
    WatchHub::StepRequest request{
        {record_.key, "hall", "i", 1}, filter_, 65'536, true, true, {}, nullptr, {}};
    for (const PublishedRevision& published : published_) {
      request.to = published;
      const auto step = hub.FindStep(request).value();
      for (std::size_t i = 0; i < step->count(); ++i) {
        std::optional<grpc::ByteBuffer> bytes = step->At(i).value();
        if (!bytes) continue;
        EXPECT_TRUE(grpc::SerializationTraits<v1::WatchMapResponse>::Deserialize(
                        &*bytes, &messages.emplace_back())
                        .ok());
      }
      request.as_snapshot = false;
      request.before = step->after();
      request.shown = step->shown();
    }
    return messages;
  }

  std::vector<std::string> Check(const Messages& messages) {
    WatchPromises promises(filter_, &history_, kTinyScale);
    promises.BeginStream(WatchPromises::Begin::kSnapshot);
    for (const v1::WatchMapResponse& message : messages) promises.Take(message);
    return promises.broken();
  }

  /// Returns the violations after `plant` has changed a correct watch.
  std::vector<std::string> Find(const std::function<void(Messages*)>& plant) {
    Messages messages = HonestMessages();
    plant(&messages);
    return Check(messages);
  }

  /// Returns the index of the n-th message of a kind, from 0.
  static std::size_t Place(const Messages& messages, Kind::KindCase kind, std::size_t n = 0) {
    for (std::size_t i = 0; i < messages.size(); ++i) {
      if (messages[i].kind_case() == kind && n-- == 0) return i;
    }
    ADD_FAILURE() << "no such message";
    return 0;
  }

  static void Drop(Messages* messages, Kind::KindCase kind, std::size_t n = 0) {
    messages->erase(messages->begin() + static_cast<std::ptrdiff_t>(Place(*messages, kind, n)));
  }

  static v1::WatchMapResponse* At(Messages* messages, Kind::KindCase kind, std::size_t n = 0) {
    return &(*messages)[Place(*messages, kind, n)];
  }

  MemoryStore store_;
  MapRecord record_;
  MapSnapshot map_{kTinyScale};
  MapHistory history_;
  std::vector<PublishedRevision> published_;
  MapFilter filter_;
};

TEST_F(PlantedFaults, AnHonestWatchBreaksNothing) {
  const Messages messages = HonestMessages();
  EXPECT_THAT(Check(messages), IsEmpty());
  // Several snapshot chunks and event batches: the faults below need them.
  (void)Place(messages, Kind::kSnapshot, 2);
  (void)Place(messages, Kind::kEvents, 1);
}

TEST_F(PlantedFaults, ADroppedEventIsUnreliable) {
  EXPECT_THAT(Find([](Messages* messages) { Drop(messages, Kind::kEvents, 1); }),
              Contains(StartsWith("Reliable:")));
}

TEST_F(PlantedFaults, ADroppedStepIsUnreliable) {
  const auto broken = Find([](Messages* messages) {
    Drop(messages, Kind::kDelta, 0);
    Drop(messages, Kind::kEvents, 0);
    Drop(messages, Kind::kProgress, 1);
  });
  EXPECT_THAT(broken, Contains(StartsWith("Reliable:")));
}

TEST_F(PlantedFaults, ATokenAheadOfItsDataIsNoBookmark) {
  EXPECT_THAT(Find([](Messages* messages) {
                At(messages, Kind::kProgress, 1)->mutable_progress()->set_revision(30);
              }),
              Contains(StartsWith("Bookmarkable:")));
}

TEST_F(PlantedFaults, ATokenBeforeItsDataIsNoBookmark) {
  EXPECT_THAT(Find([](Messages* messages) {
                const std::size_t delta = Place(*messages, Kind::kDelta, 0);
                std::swap((*messages)[delta], *At(messages, Kind::kProgress, 1));
              }),
              Contains(AnyOf(StartsWith("Bookmarkable:"), StartsWith("Reliable:"))));
}

TEST_F(PlantedFaults, AChangedBitIsNoBookmark) {
  EXPECT_THAT(Find([](Messages* messages) {
                v1::DeltaFragment* delta = At(messages, Kind::kDelta, 0)->mutable_delta();
                std::string* packed = delta->mutable_leaves(0)->mutable_packed();
                packed->back() = static_cast<char>(packed->back() ^ 1);
              }),
              Contains(StartsWith("Bookmarkable:")));
}

TEST_F(PlantedFaults, APatchOfALeafThatIsNotThereIsUnreliable) {
  EXPECT_THAT(Find([](Messages* messages) {
                v1::DeltaFragment* delta = At(messages, Kind::kDelta, 0)->mutable_delta();
                delta->mutable_leaves(0)->set_is_patch(true);
                delta->mutable_leaves(0)->set_origin_x(8000);
              }),
              Contains(StartsWith("Reliable:")));
}

TEST_F(PlantedFaults, AnotherCaptureTimeIsNoBookmark) {
  EXPECT_THAT(Find([](Messages* messages) {
                At(messages, Kind::kProgress, 0)
                    ->mutable_progress()
                    ->mutable_last_capture_time()
                    ->set_seconds(99);
              }),
              Contains(StartsWith("Bookmarkable:")));
}

TEST_F(PlantedFaults, AMissingFragmentIsNotAtomic) {
  EXPECT_THAT(Find([](Messages* messages) {
                v1::DeltaFragment* delta = At(messages, Kind::kDelta, 0)->mutable_delta();
                delta->set_fragments(2);
              }),
              Contains(StartsWith("Atomic:")));
}

TEST_F(PlantedFaults, ARevisionTwiceIsNotUnique) {
  EXPECT_THAT(Find([](Messages* messages) {
                messages->insert(messages->begin() + static_cast<std::ptrdiff_t>(
                                                         Place(*messages, Kind::kProgress, 1)),
                                 *At(messages, Kind::kProgress, 1));
              }),
              Contains(StartsWith("Unique:")));
}

TEST_F(PlantedFaults, AResumedWatchMayBeginWithTheRevisionItHasOnce) {
  const Messages messages = HonestMessages();
  const std::size_t begun = Place(messages, Kind::kProgress, 0);
  WatchPromises promises(filter_, &history_, kTinyScale);
  promises.BeginStream(WatchPromises::Begin::kSnapshot);
  for (std::size_t i = 0; i <= begun; ++i) promises.Take(messages[i]);
  promises.BeginStream(WatchPromises::Begin::kResumed);
  promises.Take(messages[begun]);
  EXPECT_THAT(promises.broken(), IsEmpty());
  promises.Take(messages[begun]);
  EXPECT_THAT(promises.broken(), Contains(StartsWith("Unique:")));
}

TEST_F(PlantedFaults, AnEventTwiceIsNotUnique) {
  EXPECT_THAT(Find([](Messages* messages) {
                v1::EventBatch* batch = At(messages, Kind::kEvents, 0)->mutable_events();
                *batch->add_events() = v1::ObjectEvent(batch->events(0));
              }),
              Contains(StartsWith("Unique:")));
}

TEST_F(PlantedFaults, EventsThatFallAreNotOrdered) {
  EXPECT_THAT(Find([](Messages* messages) {
                At(messages, Kind::kEvents, 1)->mutable_events()->mutable_events(0)->set_number(1);
              }),
              Contains(StartsWith("Ordered:")));
}

TEST_F(PlantedFaults, ARevisionThatFallsIsNotOrdered) {
  EXPECT_THAT(Find([](Messages* messages) {
                At(messages, Kind::kProgress, 2)->mutable_progress()->set_revision(5);
              }),
              Contains(StartsWith("Ordered:")));
}

TEST_F(PlantedFaults, AMissingTombstoneIsNotFiltered) {
  EXPECT_THAT(Find([](Messages* messages) {
                At(messages, Kind::kDelta, 1)->mutable_delta()->clear_removed_object_ids();
              }),
              Contains(StartsWith("Filtered:")));
}

TEST_F(PlantedFaults, WhatTheFilterDoesNotShowIsFound) {
  const Messages all = HonestMessages();
  filter_.classes = {ClassId(9999)};
  const std::vector<std::string> broken = Check(all);
  EXPECT_THAT(broken, Contains(StartsWith("Filtered: object")));
  EXPECT_THAT(broken, Contains(StartsWith("Filtered: event")));
}

TEST_F(PlantedFaults, AStreamThatGoesOnElsewhereThanItsTokenIsNotResumable) {
  const Messages messages = HonestMessages();
  WatchPromises promises(filter_, &history_, kTinyScale);
  promises.BeginStream(WatchPromises::Begin::kSnapshot);
  for (std::size_t i = 0; i <= Place(messages, Kind::kProgress, 0); ++i) {
    promises.Take(messages[i]);
  }
  ASSERT_THAT(promises.broken(), IsEmpty());
  promises.BeginStream(WatchPromises::Begin::kResumed);
  v1::WatchMapResponse created;
  created.mutable_created()->set_revision(20);
  promises.Take(created);
  EXPECT_THAT(promises.broken(), Contains(StartsWith("Resumable:")));
}

TEST_F(PlantedFaults, ACutAndResumedHonestWatchBreaksNothing) {
  const Messages messages = HonestMessages();
  const std::size_t begun = Place(messages, Kind::kProgress, 0);
  for (std::size_t cut = begun + 1; cut < messages.size(); ++cut) {
    WatchPromises promises(filter_, &history_, kTinyScale);
    promises.BeginStream(WatchPromises::Begin::kSnapshot);
    std::size_t settled = begun;
    for (std::size_t i = 0; i <= cut; ++i) {
      promises.Take(messages[i]);
      if (messages[i].has_progress()) settled = i;
    }
    promises.BeginStream(WatchPromises::Begin::kResumed);
    for (std::size_t i = settled + 1; i < messages.size(); ++i) promises.Take(messages[i]);
    EXPECT_THAT(promises.broken(), IsEmpty()) << "cut after message " << cut;
  }
}

}  // namespace
}  // namespace steadymap

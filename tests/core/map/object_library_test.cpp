#include "core/map/object_library.h"

#include <algorithm>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

using ObjectMap = std::map<ObjectId, std::shared_ptr<const MapObject>>;

std::shared_ptr<const MapObject> MakeObject(ObjectId id, std::uint64_t views) {
  auto object = std::make_shared<MapObject>();
  object->id = id;
  object->supporting_frames = views;
  return object;
}

/// Compares the results of all read operations of a library with those of a map.
void ExpectHolds(const ObjectLibrary& library, const ObjectMap& truth, ObjectId last) {
  ASSERT_EQ(library.size(), truth.size());
  ASSERT_EQ(library.empty(), truth.empty());
  ASSERT_TRUE(std::equal(library.begin(),
                         library.end(),
                         truth.begin(),
                         truth.end(),
                         [](const ObjectLibrary::Entry& entry, const ObjectMap::value_type& other) {
                           return entry.first == other.first && entry.second == other.second;
                         }));
  for (ObjectId id; id <= last; id = id.Next()) {
    const auto known = truth.find(id);
    ASSERT_EQ(library.contains(id), known != truth.end()) << id.value();
    ASSERT_EQ(library.find(id) != library.end(), known != truth.end()) << id.value();
    if (known != truth.end()) {
      ASSERT_EQ(library.find(id)->first, id);
      ASSERT_EQ(library.at(id), known->second);
    }
    const auto above = truth.upper_bound(id);
    const auto found = library.upper_bound(id);
    ASSERT_EQ(found == library.end(), above == truth.end()) << id.value();
    if (above != truth.end()) {
      ASSERT_EQ(found->first, above->first);
    }
  }
}

class RandomLibrary {
 public:
  explicit RandomLibrary(unsigned seed) : random_(seed) {}

  /// Writes or removes one object in both containers.
  void Step(ObjectLibrary* library, ObjectMap* truth) {
    const ObjectId id(std::uniform_int_distribution<std::uint64_t>(0, kLast.value())(random_));
    if (std::uniform_int_distribution(0, 99)(random_) < removed_percent_) {
      library->erase(id);
      truth->erase(id);
    } else {
      const std::shared_ptr<const MapObject> object = MakeObject(id, ++views_);
      library->insert_or_assign(id, object);
      truth->insert_or_assign(id, object);
    }
    // Alternates between mostly writes and mostly removals, so that chunks are added and removed.
    if (views_ % 200 == 0) removed_percent_ = 100 - removed_percent_;
  }

  static constexpr ObjectId kLast{100};

 private:
  std::mt19937 random_;
  std::uint64_t views_ = 0;
  int removed_percent_ = 30;
};

TEST(ObjectLibrary, IsAMapAfterAnyWritesAndSoAreItsCopies) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    RandomLibrary source(seed);
    ObjectLibrary library;
    ObjectMap truth;
    ObjectLibrary copy;
    ObjectMap truth_of_copy;
    for (int step = 0; step < 1000; ++step) {
      if (step % 37 == 0) {
        ASSERT_NO_FATAL_FAILURE(ExpectHolds(copy, truth_of_copy, RandomLibrary::kLast));
        copy = library;
        truth_of_copy = truth;
      }
      source.Step(&library, &truth);
      ASSERT_NO_FATAL_FAILURE(ExpectHolds(library, truth, RandomLibrary::kLast)) << step;
    }
  }
}

TEST(ObjectLibrary, ForEachDifferenceTellsAllThatTwoMapsDoNotShare) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    RandomLibrary source(seed);
    ObjectLibrary before;
    ObjectMap truth_before;
    for (int step = 0; step < 60; ++step) source.Step(&before, &truth_before);
    ObjectLibrary after = before;
    ObjectMap truth_after = truth_before;
    for (unsigned step = 0; step < seed; ++step) source.Step(&after, &truth_after);
    std::vector<ObjectId> told;
    ObjectLibrary::ForEachDifference(
        before, after, [&](ObjectId id, const MapObject* old, const MapObject* now) {
          EXPECT_EQ(old, truth_before.contains(id) ? truth_before.at(id).get() : nullptr);
          EXPECT_EQ(now, truth_after.contains(id) ? truth_after.at(id).get() : nullptr);
          EXPECT_NE(old, now);
          told.push_back(id);
        });
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
    std::size_t different = 0;
    for (ObjectId id; id <= RandomLibrary::kLast; id = id.Next()) {
      const auto old = truth_before.find(id);
      const auto now = truth_after.find(id);
      const bool has_old = old != truth_before.end();
      const bool has_now = now != truth_after.end();
      different += has_old != has_now || (has_old && old->second != now->second) ? 1U : 0U;
    }
    EXPECT_EQ(told.size(), different) << seed;
  }
}

TEST(ObjectLibrary, CopiesShareTheChunksThatAreNotChanged) {
  constexpr std::uint64_t kObjects = 10 * ObjectLibrary::kChunkIds;
  ObjectLibrary library;
  for (std::uint64_t id = 0; id < kObjects; ++id) {
    library.insert_or_assign(ObjectId(id), MakeObject(ObjectId(id), 0));
  }
  ObjectLibrary copy = library;
  const ObjectId changed(3 * ObjectLibrary::kChunkIds + 1);
  copy.insert_or_assign(changed, MakeObject(changed, 1));
  EXPECT_EQ(library.at(changed)->supporting_frames, 0U);
  EXPECT_EQ(copy.at(changed)->supporting_frames, 1U);
  for (std::uint64_t id = 0; id < kObjects; ++id) {
    // Entries have the same address in both copies if their chunk is shared.
    const bool is_shared = &*library.find(ObjectId(id)) == &*copy.find(ObjectId(id));
    EXPECT_EQ(is_shared, id / ObjectLibrary::kChunkIds != 3) << id;
  }
  EXPECT_EQ(library.at(changed).use_count(), 1);
  EXPECT_EQ(library.at(ObjectId(changed.value() + 1)).use_count(), 2) << "cloned with its chunk";
}

TEST(ObjectLibrary, ItsOwnChunksAreWrittenInPlace) {
  ObjectLibrary library;
  library.insert_or_assign(ObjectId(1), MakeObject(ObjectId(1), 0));
  const ObjectLibrary::Entry* place = &*library.find(ObjectId(1));
  library.insert_or_assign(ObjectId(2), MakeObject(ObjectId(2), 0));
  EXPECT_EQ(&*library.find(ObjectId(1)), place);
}

TEST(ObjectLibrary, HoldsNothingAtFirst) {
  ObjectLibrary library;
  EXPECT_TRUE(library.empty());
  EXPECT_EQ(library.begin(), library.end());
  EXPECT_EQ(library.find(ObjectId(1)), library.end());
  EXPECT_EQ(library.upper_bound(ObjectId()), library.end());
  library.erase(ObjectId(1));
  EXPECT_EQ(library.size(), 0U);
}

TEST(ObjectLibrary, HoldsTheHighestIds) {
  constexpr ObjectId kHighest{std::numeric_limits<std::uint64_t>::max()};
  ObjectLibrary library;
  library.insert_or_assign(kHighest, MakeObject(kHighest, 5));
  library.insert_or_assign(ObjectId(1), MakeObject(ObjectId(1), 0));
  EXPECT_EQ(library.at(kHighest)->supporting_frames, 5U);
  EXPECT_EQ(library.upper_bound(ObjectId(1))->first, kHighest);
  EXPECT_EQ(library.upper_bound(kHighest), library.end());
}

}  // namespace
}  // namespace steadymap

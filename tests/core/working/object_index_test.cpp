#include "core/working/object_index.h"

#include <map>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kInfinity;
using ::steadymap::testing::kNan;

Box BoxAround(const Eigen::Vector3d& center_world, const Eigen::Vector3d& size_m) {
  return {center_world - 0.5 * size_m, center_world + 0.5 * size_m};
}

std::vector<ObjectId> Ids(std::initializer_list<std::uint64_t> values) {
  std::vector<ObjectId> ids;
  for (const std::uint64_t value : values) ids.emplace_back(value);
  return ids;
}

/// Returns the expected result of the index, by linear search.
std::vector<ObjectId> FindByWalk(const std::map<ObjectId, Box>& bounds_world, const Box& box) {
  std::vector<ObjectId> found;
  for (const auto& [id, bounds] : bounds_world) {
    if (!bounds.isEmpty() && !box.isEmpty() && bounds.intersects(box)) found.push_back(id);
  }
  return found;
}

/// A source of random boxes of all sizes: many on cell borders, some empty, degenerate or infinite.
class BoxSource {
 public:
  explicit BoxSource(unsigned seed) : random_(seed) {}

  Box Next() {
    switch (std::uniform_int_distribution(0, 19)(random_)) {
      case 0:
        return {};
      case 1:
        return {Eigen::Vector3d::Constant(-kInfinity), Eigen::Vector3d::Constant(kInfinity)};
      case 2:
        return BoxAround(Position(), {400.0, 400.0, 3.0});
      case 3:
        return BoxAround(Position(), Eigen::Vector3d::Zero());
      case 4:
        return BoxAround((Position() / ObjectIndex::kCellM).array().round() * ObjectIndex::kCellM,
                         Eigen::Vector3d::Constant(2.0 * ObjectIndex::kCellM));
      case 5:
        return BoxAround(1e9 * Position(), {1.0, 1.0, 1.0});
      default:
        return BoxAround(Position(), {Side(), Side(), Side()});
    }
  }

 private:
  Eigen::Vector3d Position() {
    std::uniform_real_distribution<double> along_m(-30.0, 30.0);
    return {along_m(random_), along_m(random_), along_m(random_)};
  }

  double Side() { return std::uniform_real_distribution(0.0, 12.0)(random_); }

  std::mt19937 random_;
};

TEST(ObjectIndex, AnswersAsAWalkOverAllBoundsAfterAnyUpdates) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    BoxSource boxes(1000 + seed);
    std::uniform_int_distribution<std::uint64_t> any_id(1, 60);
    ObjectIndex index;
    std::map<ObjectId, Box> bounds_world;
    std::size_t answers = 0;
    for (int step = 0; step < 1500; ++step) {
      const ObjectId id(any_id(random));
      if (step % 5 == 4) {
        index.Erase(id);
        bounds_world.erase(id);
      } else {
        const Box bounds = boxes.Next();
        index.Update(id, bounds);
        bounds_world[id] = bounds;
      }
      const Box asked = boxes.Next();
      const std::vector<ObjectId> found = index.Find(asked);
      answers += found.size();
      ASSERT_EQ(found, FindByWalk(bounds_world, asked)) << "seed " << seed << " step " << step;
    }
    EXPECT_GT(answers, 1500U);
  }
}

TEST(ObjectIndex, FindsNothingWhereNothingIs) {
  ObjectIndex index;
  EXPECT_TRUE(index.Find(BoxAround(Eigen::Vector3d::Zero(), {1.0, 1.0, 1.0})).empty());
  index.Update(ObjectId(1), BoxAround({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}));
  EXPECT_TRUE(index.Find(Box()).empty());
  EXPECT_TRUE(index.Find(BoxAround({0.0, 0.0, 2.0}, {1.0, 1.0, 1.0})).empty()) << "above it";
  index.Erase(ObjectId(2));
  EXPECT_EQ(index.size(), 1U);
}

TEST(ObjectIndex, EmptyBoundsAreNowhere) {
  ObjectIndex index;
  const Box everywhere(Eigen::Vector3d::Constant(-kInfinity), Eigen::Vector3d::Constant(kInfinity));
  index.Update(ObjectId(1), Box());
  EXPECT_EQ(index.size(), 0U);
  index.Update(ObjectId(1), BoxAround({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}));
  EXPECT_EQ(index.Find(everywhere), Ids({1}));
  index.Update(ObjectId(1), Box());
  EXPECT_TRUE(index.Find(everywhere).empty());
  EXPECT_TRUE(index.BoundsOf(ObjectId(1)).isEmpty());
}

TEST(ObjectIndex, HugeBoundsAreFoundFromEverySide) {
  ObjectIndex index;
  index.Update(ObjectId(1), BoxAround({0.0, 0.0, 0.0}, {2e4, 2e4, 10.0}));
  index.Update(ObjectId(2), BoxAround({8000.0, 0.0, 0.0}, {1.0, 1.0, 1.0}));
  EXPECT_EQ(index.Find(BoxAround({8000.0, 0.0, 0.0}, {1.0, 1.0, 1.0})), Ids({1, 2}));
  EXPECT_EQ(index.Find(BoxAround({-8000.0, 90.0, 0.0}, {1.0, 1.0, 1.0})), Ids({1}));
  index.Update(ObjectId(1), BoxAround({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}));
  EXPECT_TRUE(index.Find(BoxAround({-8000.0, 90.0, 0.0}, {1.0, 1.0, 1.0})).empty());
}

TEST(ObjectIndex, BoundsThatAreNotNumbersHarmNobody) {
  ObjectIndex index;
  index.Update(ObjectId(1), BoxAround({kNan, 0.0, 0.0}, {1.0, 1.0, 1.0}));
  index.Update(ObjectId(2), BoxAround({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}));
  EXPECT_EQ(index.Find(BoxAround({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0})), Ids({2}));
  EXPECT_TRUE(index.Find(BoxAround({kNan, kNan, kNan}, {1.0, 1.0, 1.0})).empty());
  index.Update(ObjectId(1), BoxAround({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}));
  EXPECT_EQ(index.Find(BoxAround({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0})), Ids({1, 2}));
}

TEST(ObjectIndex, CopiesGoTheirOwnWays) {
  ObjectIndex index;
  const Box box = BoxAround({3.0, -7.0, 0.0}, {1.0, 1.0, 1.0});
  index.Update(ObjectId(1), box);
  ObjectIndex copy = index;
  index.Erase(ObjectId(1));
  EXPECT_TRUE(index.Find(box).empty());
  EXPECT_EQ(copy.Find(box), Ids({1}));
}

}  // namespace
}  // namespace steadymap

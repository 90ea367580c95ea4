#include "core/policy/stage_observer.h"

#include <algorithm>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/policy/map_story.h"

namespace steadymap {
namespace {

using ::steadymap::testing::ConfigOf;
using ::steadymap::testing::ExpectSameMap;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::Goods;
using ::steadymap::testing::MapStory;

using Stages = std::vector<std::optional<MapperStage>>;

/// Records the stages, with an empty entry for each exit from the mapper.
class StageRecord final : public StageObserver {
 public:
  void Enter(MapperStage stage) override { stages_.emplace_back(stage); }

  void Leave() override { stages_.emplace_back(std::nullopt); }

  const Stages& stages() const { return stages_; }

 private:
  Stages stages_;
};

Stages StagesOfAFrame(UpdatePolicy policy) {
  StageRecord record;
  MapStory story(ConfigOf(policy), &record);
  const std::vector<Frame> frames = testing::LookAtScene({FarWall(), Goods(0.0)}, 0, 1);
  story.Play(frames, 2);
  return record.stages();
}

TEST(StageObserver, HearsEveryStageOfPocdOnceInOrder) {
  const Stages heard = StagesOfAFrame(UpdatePolicy::kPocd);
  const Stages expected = {MapperStage::kCloud,
                           MapperStage::kPolicy,
                           MapperStage::kGuard,
                           MapperStage::kRegistration,
                           MapperStage::kAssociation,
                           MapperStage::kLooks,
                           MapperStage::kSegments,
                           MapperStage::kIntegration,
                           MapperStage::kFreeSpace,
                           MapperStage::kFrameEnd,
                           std::nullopt,
                           MapperStage::kCommit,
                           std::nullopt};
  EXPECT_TRUE(heard == expected);
}

TEST(StageObserver, HearsOneStageOfAPolicyThatTellsNoMore) {
  const Stages heard = StagesOfAFrame(UpdatePolicy::kStatic);
  const Stages expected = {MapperStage::kCloud,
                           MapperStage::kPolicy,
                           MapperStage::kFrameEnd,
                           std::nullopt,
                           MapperStage::kCommit,
                           std::nullopt};
  EXPECT_TRUE(heard == expected);
}

TEST(StageObserver, ChangesNothing) {
  StageRecord record;
  MapStory watched(ConfigOf(UpdatePolicy::kPocd), &record);
  MapStory alone(ConfigOf(UpdatePolicy::kPocd));
  watched.Look({FarWall(), Goods(0.0)}, 8);
  alone.Look({FarWall(), Goods(0.0)}, 8);
  ExpectSameMap(watched.map(), alone.map());
}

TEST(StageObserver, EveryStageHasANameOfItsOwn) {
  EXPECT_EQ(kMapperStageCount, static_cast<std::size_t>(MapperStage::kCommit) + 1);
  const std::set<std::string_view> names(kMapperStageNames.begin(), kMapperStageNames.end());
  EXPECT_EQ(names.size(), kMapperStageCount);
}

}  // namespace
}  // namespace steadymap

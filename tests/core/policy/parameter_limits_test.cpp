// Maps of the pocd policy with each parameter at a limit of its range.

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/policy_parameters.h"
#include "tests/core/policy/map_story.h"
#include "tests/core/policy/room_drive.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Drive;
using ::steadymap::testing::ExpectSameMap;
using ::steadymap::testing::From;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::Mislead;
using ::steadymap::testing::PocdConfig;
using ::steadymap::testing::Room;
using ::steadymap::testing::RoomWithout;

/// Returns drives of two robots through a room that changes, in the order of their upload: with
/// labels, without, and with wrong poses.
std::vector<std::vector<Frame>> Drives() {
  std::vector<Frame> unlabelled = From("other", Drive(RoomWithout(1), 0, 5, 7200.0));
  for (Frame& frame : unlabelled) frame.labels = {};
  return {Drive(Room(), 0, 5),
          Drive(RoomWithout(2), 0, 5, 3600.0),
          unlabelled,
          Mislead(Drive(Room(), 5, 5, 3600.0), 1.0, 0.5)};
}

TEST(PocdParameters, BuildAValidMapAtEachLimit) {
  const std::vector<std::vector<Frame>> drives = Drives();
  for (const PolicyParameter& parameter : ParametersOf(UpdatePolicy::kPocd)) {
    for (const double limit : {parameter.min, parameter.max}) {
      SCOPED_TRACE(std::string(parameter.name) + " = " + std::to_string(limit));
      MapConfig config = PocdConfig();
      config.parameters = {{std::string(parameter.name), limit}};
      MapStory story(config);
      for (const std::vector<Frame>& frames : drives) {
        story.Play(frames, frames.size());
        story.EndSession();
      }
      ExpectSameMap(story.told(), story.map());
      for (const auto& [id, object] : story.map().objects) {
        EXPECT_GT(object->belief.stationarity(), 0.0);
        EXPECT_LT(object->belief.stationarity(), 1.0);
      }
    }
  }
}

}  // namespace
}  // namespace steadymap

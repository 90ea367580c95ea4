#include "server/mapping/class_log.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

SemanticClass ClassOf(std::uint16_t id, const std::string& name) {
  SemanticClass row;
  row.id = ClassId(id);
  row.name = name;
  return row;
}

PendingClasses Addition(std::uint16_t id, const std::string& name) {
  return {{ClassOf(id, name)}, [](const absl::Status&) {}};
}

TEST(ClassLog, LabelsAreKnownOnceTheirClassIsDurable) {
  ClassLog log{MapConfig()};
  const std::size_t before = log.classes().size();
  ASSERT_TRUE(log.Queue(Addition(900, "sofa")).ok());
  EXPECT_EQ(log.classes().size(), before);
  const std::vector<PendingClasses> taken = log.TakeQueued();
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_TRUE(log.TakeQueued().empty());
  const auto labels = log.labels();
  log.Append(taken[0].classes);
  EXPECT_EQ(log.classes().back(), ClassOf(900, "sofa"));
  EXPECT_NE(log.labels(), labels) << "readers keep the labels that they have";
}

TEST(ClassLog, RefusesWhatConflictsWithTheTableOrTheQueue) {
  ClassLog log{MapConfig()};
  ASSERT_TRUE(log.Queue(Addition(900, "sofa")).ok());
  EXPECT_TRUE(absl::IsInvalidArgument(log.Queue(Addition(900, "table"))));
  log.Append(log.TakeQueued()[0].classes);
  EXPECT_TRUE(absl::IsInvalidArgument(log.Queue(Addition(900, "table"))));
  EXPECT_TRUE(log.Queue(Addition(901, "table")).ok());
}

TEST(ClassLog, StartsAgainFromTheStoredTable) {
  ClassLog log{MapConfig()};
  log.Append({ClassOf(900, "sofa")});
  log.Reset({ClassOf(5, "crate")});
  EXPECT_EQ(log.classes(), std::vector<SemanticClass>{ClassOf(5, "crate")});
  EXPECT_TRUE(log.Queue(Addition(900, "sofa")).ok());
}

TEST(ClassLog, NoAdditionIsLostWhenItCloses) {
  ClassLog log{MapConfig()};
  ASSERT_TRUE(log.Queue(Addition(900, "sofa")).ok());
  const absl::Status deleted = absl::NotFoundError("the map is deleted");
  EXPECT_EQ(log.Close(deleted).size(), 1U);
  EXPECT_EQ(log.Queue(Addition(901, "table")), deleted);
  EXPECT_TRUE(log.TakeQueued().empty());
}

}  // namespace
}  // namespace steadymap

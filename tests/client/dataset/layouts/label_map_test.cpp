#include "client/dataset/layouts/label_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

TEST(LabelMap, MapsWhatItNamesAndKeepsTheRest) {
  const TemporaryFolder folder;
  const auto map = LabelMap::Load(folder.Write("m.txt", "# a comment\n3 4 # wall\n\n15\t3\n"));
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_FALSE(map->is_identity());
  EXPECT_EQ(map->Apply(3), 4);
  EXPECT_EQ(map->Apply(15), 3);
  EXPECT_EQ(map->Apply(4), 4);
  EXPECT_EQ(map->Apply(65535), 65535);
  Image<std::uint16_t> labels(3, 1);
  labels.At(0, 0) = 3;
  labels.At(1, 0) = 9;
  labels.At(2, 0) = 15;
  map->Apply(&labels);
  EXPECT_EQ(labels.At(0, 0), 4);
  EXPECT_EQ(labels.At(1, 0), 9);
  EXPECT_EQ(labels.At(2, 0), 3);
}

TEST(LabelMap, EmptyFileAndSelfMappingChangeNothing) {
  const TemporaryFolder folder;
  EXPECT_TRUE(LabelMap().is_identity());
  EXPECT_TRUE(LabelMap::Load(folder.Write("a.txt", ""))->is_identity());
  EXPECT_TRUE(LabelMap::Load(folder.Write("b.txt", "5 5\n65535 65535\n"))->is_identity());
}

TEST(LabelMap, NamesTheLineThatIsWrong) {
  const TemporaryFolder folder;
  for (const char* line : {"3", "3 4 5", "a b", "-1 4", "3 65536", "3.5 4", "nan 1", "3 1e99"}) {
    const auto map = LabelMap::Load(folder.Write("m.txt", std::string("1 2\n") + line + "\n"));
    EXPECT_EQ(map.status().code(), absl::StatusCode::kInvalidArgument) << line;
    EXPECT_THAT(std::string(map.status().message()), ::testing::HasSubstr("m.txt:2")) << line;
  }
  const auto twice = LabelMap::Load(folder.Write("m.txt", "1 2\n1 3\n"));
  EXPECT_THAT(std::string(twice.status().message()), ::testing::HasSubstr("m.txt:2"));
}

TEST(LabelMap, MissingFileIsNotFound) {
  EXPECT_EQ(LabelMap::Load("/nowhere/m.txt").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace steadymap

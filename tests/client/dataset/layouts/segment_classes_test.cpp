#include "client/dataset/layouts/segment_classes.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::testing::HasSubstr;

TEST(SegmentClasses, ReadsTheColumnsItNeedsOfACsvTable) {
  const TemporaryFolder folder;
  const auto classes = SegmentClasses::Load(folder.Write(
      "t.csv", "ClassID,Name, InstanceID ,R\r\n3,SM_Bed,7,255\r\n\r\n4,\"a, b\",8,0\n"));
  // Names with commas are not supported.
  EXPECT_FALSE(classes.ok());
  const auto plain = SegmentClasses::Load(
      folder.Write("t.csv", "ClassID,Name, InstanceID ,R\r\n3,SM_Bed,7,255\r\n\r\n4,Chair,8,0\n"));
  ASSERT_TRUE(plain.ok()) << plain.status();
  EXPECT_EQ(plain->ClassOf(7), 3);
  EXPECT_EQ(plain->ClassOf(8), 4);
  EXPECT_EQ(plain->ClassOf(9), 0);
  Image<std::uint16_t> image(2, 1, 7);
  image.At(1, 0) = 65535;
  plain->Apply(&image);
  EXPECT_EQ(image.At(0, 0), 3);
  EXPECT_EQ(image.At(1, 0), 0);
}

TEST(SegmentClasses, ReadsAJsonList) {
  const TemporaryFolder folder;
  const auto classes = SegmentClasses::Load(folder.Write(
      "t.json",
      R"([{"id": 1, "isthing": true, "score": 0.97, "category_id": 57, "instance_id": 0},
          {"id": 2, "isthing": false, "category_id": 12, "area": 100}])"));
  ASSERT_TRUE(classes.ok()) << classes.status();
  EXPECT_EQ(classes->ClassOf(1), 57);
  EXPECT_EQ(classes->ClassOf(2), 12);
  EXPECT_TRUE(SegmentClasses::Load(folder.Write("none.json", "[]")).ok());
}

TEST(SegmentClasses, RefusesAnythingElseNamingThePlace) {
  struct Case {
    const char* name;
    std::string text;
    const char* where;
  };

  const std::string header = "InstanceID,ClassID\n";
  for (const Case& c : {Case{"t.csv", "", "t.csv"},
                        Case{"t.csv", "1,2\n", "t.csv:1"},
                        Case{"t.csv", "InstanceID,Class\n", "t.csv:1"},
                        Case{"t.csv", header + "1\n", "t.csv:2"},
                        Case{"t.csv", header + "1,x\n", "t.csv:2"},
                        Case{"t.csv", header + "1,2\n-1,2\n", "t.csv:3"},
                        Case{"t.csv", header + "1,65536\n", "t.csv:2"},
                        Case{"t.csv", header + "1,nan\n", "t.csv:2"},
                        Case{"t.csv", header + "1,2\n1,3\n", "t.csv:3"},
                        Case{"t.json", "", "t.json"},
                        Case{"t.json", "{}", "t.json"},
                        Case{"t.json", "[{\"id\": 1, \"category_id\"", "t.json"},
                        Case{"t.json", "[1]", "entry 1"},
                        Case{"t.json", R"([{"id": 1}])", "entry 1"},
                        Case{"t.json", R"([{"id": "1", "category_id": 2}])", "entry 1"},
                        Case{"t.json", R"([{"id": 1.5, "category_id": 2}])", "entry 1"},
                        Case{"t.json", std::string(100'000, '['), "t.json"}}) {
    const TemporaryFolder folder;
    const auto classes = SegmentClasses::Load(folder.Write(c.name, c.text));
    ASSERT_FALSE(classes.ok()) << c.text.substr(0, 100);
    EXPECT_THAT(std::string(classes.status().message()), HasSubstr(c.where));
  }
  EXPECT_EQ(SegmentClasses::Load("/nowhere/t.csv").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(SegmentClasses::Load("/nowhere/t.json").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace steadymap

#include "client/dataset/files/folder_listing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

TEST(NaturallyBefore, ComparesRunsOfDigitsAsNumbers) {
  EXPECT_TRUE(NaturallyBefore("2.png", "10.png"));
  EXPECT_FALSE(NaturallyBefore("10.png", "2.png"));
  EXPECT_TRUE(NaturallyBefore("0009.png", "10.png"));
  EXPECT_TRUE(NaturallyBefore("a2b9", "a2b10"));
  EXPECT_TRUE(NaturallyBefore("frame-1", "frame-1a"));
  EXPECT_TRUE(NaturallyBefore("99999999999999999999998", "99999999999999999999999"));
  EXPECT_FALSE(NaturallyBefore("same", "same"));
  EXPECT_TRUE(NaturallyBefore("", "a"));
}

TEST(NaturallyBefore, IsAStrictOrderEvenForLeadingZeros) {
  EXPECT_NE(NaturallyBefore("01", "1"), NaturallyBefore("1", "01"));
}

TEST(FindEntry, AcceptsBothSpellings) {
  const TemporaryFolder folder;
  folder.Write("RGB/0.png", "");
  folder.Write("laser scans/0.csv", "");
  EXPECT_EQ(FindEntry(folder.path(), "rgb").filename(), "RGB");
  EXPECT_EQ(FindEntry(folder.path(), "RGB").filename(), "RGB");
  EXPECT_EQ(FindEntry(folder.path(), "Laser Scans").filename(), "laser scans");
  EXPECT_TRUE(FindEntry(folder.path(), "depth").empty());
  EXPECT_TRUE(FindEntry(folder.path() / "gone", "depth").empty());
}

TEST(ListFiles, FindsByEndingInNaturalOrder) {
  const TemporaryFolder folder;
  for (const char* name : {"10.png", "9.PNG", "0.jpg", "notes.txt", "1.png/file"}) {
    folder.Write(name, "");
  }
  std::vector<std::string> names;
  for (const auto& file : ListFiles(folder.path(), {".png"})) names.push_back(file.filename());
  EXPECT_THAT(names, ::testing::ElementsAre("9.PNG", "10.png"));
  EXPECT_TRUE(ListFiles(folder.path() / "gone", {".png"}).empty());
  ASSERT_EQ(ListFolders(folder.path()).size(), 1U);
  EXPECT_EQ(ListFolders(folder.path())[0].filename(), "1.png");
}

}  // namespace
}  // namespace steadymap

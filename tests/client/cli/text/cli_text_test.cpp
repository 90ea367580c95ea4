#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cli/maps/class_table_file.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/text/number_text.h"
#include "client/cli/text/output_file.h"
#include "client/cli/upload/progress_report.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

TEST(NumberText, LengthsHaveTheUnitThatKeepsThemShort) {
  EXPECT_EQ(LengthText(3.0), "3 m");
  EXPECT_EQ(LengthText(12.345), "12.35 m");
  EXPECT_EQ(LengthText(0.05), "5 cm");
  EXPECT_EQ(LengthText(0.155), "15.5 cm");
  EXPECT_EQ(LengthText(0.0025), "2.5 mm");
  EXPECT_EQ(LengthText(0.0), "0 m");
  EXPECT_EQ(LengthText(-0.05), "-5 cm");
}

TEST(NumberText, SizesAndCounts) {
  EXPECT_EQ(BytesText(0), "0 B");
  EXPECT_EQ(BytesText(1023), "1023 B");
  EXPECT_EQ(BytesText(1536), "1.5 KiB");
  EXPECT_EQ(BytesText(std::uint64_t{200} << 20), "200 MiB");
  EXPECT_EQ(CountText(0), "0");
  EXPECT_EQ(CountText(999), "999");
  EXPECT_EQ(CountText(1000), "1 000");
  EXPECT_EQ(CountText(1234567), "1 234 567");
}

TEST(NumberText, DurationsAndMoments) {
  EXPECT_EQ(DurationText(0.42), "0.42 s");
  EXPECT_EQ(DurationText(12.34), "12.3 s");
  EXPECT_EQ(DurationText(245.0), "4 min 05 s");
  google::protobuf::Timestamp moment;
  moment.set_seconds(1'714'564'800);
  EXPECT_EQ(TimeText(moment), "2024-05-01T12:00:00Z");
  moment.set_nanos(250'000'000);
  EXPECT_EQ(TimeText(moment), "2024-05-01T12:00:00.25Z");
}

TEST(ParseTime, IsTakenAsTextAndAsSeconds) {
  const auto nanoseconds = [](const char* text) {
    return ParseTime(text).value_or(Timestamp()).nanoseconds();
  };
  EXPECT_EQ(nanoseconds("2024-05-01T12:00:00Z"), 1'714'564'800'000'000'000);
  EXPECT_EQ(nanoseconds("2024-05-01T14:00:00.25+02:00"), 1'714'564'800'250'000'000);
  EXPECT_EQ(nanoseconds("1714564800"), 1'714'564'800'000'000'000);
  EXPECT_EQ(nanoseconds("1714564800.123456789"), 1'714'564'800'123'456'789);
  EXPECT_EQ(nanoseconds("1714564800.1234567899"), 1'714'564'800'123'456'789);
  EXPECT_TRUE(ParseTime("0").ok());
}

TEST(ParseTime, AnythingElseIsAnError) {
  for (const char* text : {"",
                           "now",
                           "infinite-future",
                           "2024-05-01",
                           "2024-13-01T00:00:00Z",
                           "1969-12-31T23:59:59Z",
                           "2300-01-01T00:00:00Z",
                           "-1",
                           "1e9",
                           "1.",
                           ".5",
                           "1.2.3",
                           "99999999999999999999"}) {
    EXPECT_EQ(ParseTime(text).status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
}

TEST(ParseMapArgument, AnIdIsInTheTenantDefault) {
  EXPECT_EQ(ParseMapArgument("kitchen").value(), (MapName{"default", "kitchen"}));
  EXPECT_EQ(ParseMapArgument("tenants/acme/maps/hall-2").value(), (MapName{"acme", "hall-2"}));
}

TEST(ParseMapArgument, AnythingElseIsAnError) {
  for (const char* text :
       {"", "Kitchen", "a b", "-x", "tenants/acme", "tenants/A/maps/b", "../x"}) {
    EXPECT_EQ(ParseMapArgument(text).status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
}

TEST(ParsePoint, TakesThreeNumbers) {
  EXPECT_EQ(ParsePoint("1,-2.5,3e-1").value(), Eigen::Vector3d(1.0, -2.5, 0.3));
}

TEST(ParsePoint, AnythingElseIsAnError) {
  for (const char* text : {"",
                           "1",
                           "1,2",
                           "1,2,",
                           "1,2,3,4",
                           "1,2,x",
                           "1 2 3",
                           "1,2,nan",
                           "inf,0,0",
                           "1,2,3 ",
                           "1,2,1e999"}) {
    EXPECT_EQ(ParsePoint(text).status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
}

TEST(ParseBox, TakesTheLowestAndTheHighestCorner) {
  const Box box = ParseBox("-1,-2,-3,4,5,6").value();
  EXPECT_EQ(box.min(), Eigen::Vector3d(-1, -2, -3));
  EXPECT_EQ(box.max(), Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE(ParseBox("1,1,1,1,1,1").ok());
}

TEST(ParseBox, CornersInTheWrongOrderAreAnError) {
  EXPECT_EQ(ParseBox("0,0,1,1,1,0").status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ParseBox("0,0,1").status().code(), absl::StatusCode::kInvalidArgument);
}

/// Provides a separate folder for each test.
class FileTest : public ::testing::Test {
 protected:
  std::size_t FileCount() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_.path()), {}));
  }

  TemporaryFolder folder_;
};

using LoadClassTableTest = FileTest;

TEST_F(LoadClassTableTest, ReadsIdsNamesAndMotions) {
  const auto classes = LoadClassTable(
      folder_.Write("classes.txt",
                    "# ids\n0 background\n\n7 stacked goods semi-static # boxes\n13 dynamic\n"
                    "14 fork truck dynamic\n2 ceiling background\n"));
  ASSERT_TRUE(classes.ok()) << classes.status();
  EXPECT_EQ(*classes,
            (std::vector<SemanticClass>{{ClassId(0), "background", ClassMotion::kStatic},
                                        {ClassId(7), "stacked goods", ClassMotion::kSemiStatic},
                                        {ClassId(13), "dynamic", ClassMotion::kStatic},
                                        {ClassId(14), "fork truck", ClassMotion::kDynamic},
                                        {ClassId(2), "ceiling", ClassMotion::kStatic, true}}));
}

TEST_F(LoadClassTableTest, ErrorsNameFileAndLine) {
  const auto error_of = [this](const std::string& text) {
    const auto classes = LoadClassTable(folder_.Write("bad.txt", text));
    EXPECT_EQ(classes.status().code(), absl::StatusCode::kInvalidArgument) << text;
    const std::string message(classes.status().message());
    return message.substr(std::min(message.size(), message.find("bad.txt")));
  };
  EXPECT_TRUE(error_of("0 floor\n70000 wall\n").starts_with("bad.txt:2: expected an id in [0, "));
  EXPECT_TRUE(error_of("-1 wall\n").starts_with("bad.txt:1: expected an id"));
  EXPECT_TRUE(error_of("1.5 wall\n").starts_with("bad.txt:1: expected an id"));
  EXPECT_TRUE(error_of("wall 1\n").starts_with("bad.txt:1: expected an id"));
  EXPECT_TRUE(error_of("# ids\n\n3\n").starts_with("bad.txt:3: expected a name"));
  const std::string misspelt = error_of("1 floor\n2 fork truck dynamik\n");
  EXPECT_TRUE(misspelt.starts_with("bad.txt:2: ")) << misspelt;
  EXPECT_NE(misspelt.find("got \"dynamik\""), std::string::npos) << misspelt;
  EXPECT_TRUE(error_of("1 person moving\n").starts_with("bad.txt:1: "));
  EXPECT_TRUE(error_of("1 person dynamic color=red\n").starts_with("bad.txt:1: "));
  EXPECT_EQ(error_of("1 floor\n2 wall\n1 rack\n"),
            "bad.txt:3: expected each id once, got 1 again after line 1");
}

TEST_F(LoadClassTableTest, FilesWithoutAnyClassAreErrors) {
  EXPECT_FALSE(LoadClassTable(folder_.Write("no-name.txt", "3\n")).ok());
  EXPECT_FALSE(LoadClassTable(folder_.Write("empty.txt", "# nothing\n")).ok());
  EXPECT_EQ(LoadClassTable(folder_.path() / "missing").status().code(),
            absl::StatusCode::kNotFound);
}

using OutputFileTest = FileTest;

TEST_F(OutputFileTest, AppearsWhenItIsCommitted) {
  const std::filesystem::path path = folder_.path() / "map.ply";
  {
    auto file = OutputFile::Create(path);
    ASSERT_TRUE(file.ok()) << file.status();
    ASSERT_TRUE(file->Write("abc").ok());
    EXPECT_FALSE(std::filesystem::exists(path));
    ASSERT_TRUE(file->Write("def").ok());
    ASSERT_TRUE(file->Commit().ok());
  }
  EXPECT_EQ(ContentOf(path), "abcdef");
  EXPECT_EQ(FileCount(), 1U);
}

TEST_F(OutputFileTest, WithoutACommitTheOldFileStaysAndNothingElse) {
  const std::filesystem::path path = folder_.Write("map.ply", "old");
  {
    auto file = OutputFile::Create(path);
    ASSERT_TRUE(file.ok()) << file.status();
    ASSERT_TRUE(file->Write("new").ok());
  }
  EXPECT_EQ(ContentOf(path), "old");
  EXPECT_EQ(FileCount(), 1U);
}

TEST_F(OutputFileTest, WhatCannotBeWrittenIsAnErrorWithThePath) {
  for (const std::filesystem::path& path :
       {folder_.path() / "missing" / "map.ply", folder_.path()}) {
    const auto file = OutputFile::Create(path);
    ASSERT_FALSE(file.ok());
    EXPECT_NE(std::string(file.status().message()).find(path.string()), std::string::npos);
  }
}

TEST(ProgressReport, CountsRefusedFramesApartAndNamesTheirReasons) {
  std::ostringstream out;
  double now_s = 0.0;
  ProgressReport report(&out, false, "integrated", 3, [&] { return now_s; });
  now_s = 2.0;
  report.AddRefusalReason("NON_FINITE_POSE");
  report.AddRefusalReason("LABEL_OUT_OF_RANGE");
  report.AddRefusalReason("NON_FINITE_POSE");
  report.Update(1, 3, 2);
  EXPECT_EQ(out.str(),
            "1/3 frames integrated, 2 refused (LABEL_OUT_OF_RANGE, NON_FINITE_POSE), "
            "0.5 frames/s\n");
}

TEST(ProgressReport, NamesWhatItCounts) {
  std::ostringstream out;
  double now_s = 0.0;
  ProgressReport report(
      &out, false, "evaluated", 2, [&] { return now_s; }, "cases");
  now_s = 4.0;
  report.Update(2, 2);
  EXPECT_EQ(out.str(), "2/2 cases evaluated, 0.5 cases/s\n");
}

TEST(ProgressReport, DrawsTheBarToItsEndWhereTheLastFramesAreRefused) {
  std::ostringstream out;
  ProgressReport report(&out, true, "integrated", 10, [] { return 0.0; });
  report.Update(8, 10, 2);
  const std::string text = out.str();
  EXPECT_NE(text.find("#] 8/10 frames integrated, 2 refused, -"), std::string::npos) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '#'), 30);
}

TEST(ProgressReport, WritesALineEveryTenthOfTheWay) {
  std::ostringstream out;
  double now_s = 100.0;
  ProgressReport report(&out, false, "integrated", 40, [&] { return now_s; });
  for (std::size_t done = 1; done <= 40; ++done) {
    now_s += 0.5;
    report.Update(done, done);
  }
  report.End();
  const std::string text = out.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 10);
  EXPECT_EQ(text.substr(0, text.find('\n')), "4/40 frames integrated, 2.0 frames/s");
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
}

TEST(ProgressReport, DrawsABarOverItselfOnATerminal) {
  std::ostringstream out;
  double now_s = 0.0;
  ProgressReport report(&out, true, "integrated", 10, [&] { return now_s; });
  now_s = 1.0;
  report.Update(5, 10);
  EXPECT_NE(out.str().find("[###############---------------] 5/10 frames integrated, 5.0 frames/s"),
            std::string::npos);
  const std::size_t length = out.str().size();
  now_s = 1.01;
  report.Update(6, 10);
  EXPECT_EQ(out.str().size(), length) << "redrawn too soon";
  report.Update(10, 10);
  EXPECT_GT(out.str().size(), length) << "the end is always drawn";
  report.End();
  EXPECT_EQ(out.str().back(), '\n');
}

TEST(ProgressReport, OfNoFramesInNoTimeShowsCountsWithoutARate) {
  for (const bool is_terminal : {false, true}) {
    std::ostringstream out;
    ProgressReport report(&out, is_terminal, "written", 0, [] { return 0.0; });
    report.Update(0, 0);
    report.Update(3, 1);
    report.End();
    EXPECT_THAT(out.str(), ::testing::HasSubstr("1/1 frames written, -"));
  }
}

TEST(FixedText, HasNoNegativeZero) {
  EXPECT_EQ(FixedText(-0.0004, 2), "0.00");
  EXPECT_EQ(FixedText(-0.0, 0), "0");
  EXPECT_EQ(FixedText(-0.006, 2), "-0.01");
  EXPECT_EQ(FixedText(-10.0, 1), "-10.0");
}

}  // namespace
}  // namespace steadymap

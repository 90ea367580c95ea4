#include "client/bench/evaluation/report/score_table.h"

#include <algorithm>
#include <sstream>

#include <gtest/gtest.h>

#include "client/bench/evaluation/method/method.h"
#include "client/bench/evaluation/method/stage_clock.h"
#include "client/bench/evaluation/report/score_picture.h"
#include "client/bench/evaluation/report/stage_table.h"
#include "client/cli/bench/evaluation_json.h"

namespace steadymap {
namespace {

Evaluation Example() {
  Evaluation evaluation;
  evaluation.title = "1-5";
  evaluation.frame_count = 746;
  evaluation.has_history = true;
  MethodScore& row = evaluation.rows.emplace_back();
  row.name = "static";
  row.map.near = {780, 220, 991, 9, 5000};
  row.map.voxel = {600, 400, 750, 250, 5000};
  row.map.ghosts = {79, 100};
  row.map.kept = {45, 50};
  row.map.trail = {4, 10};
  row.cost.memory_bytes = 6'600'000;
  row.cost.delta_bytes_per_frame = 12'345.0;
  row.cost.median_frame_ms = 0.74;
  evaluation.rows.push_back(row);
  evaluation.rows[1].name = "fresh";
  evaluation.rows[1].last_sequence_only = true;
  evaluation.rows[1].map.kept = {9, 50};
  return evaluation;
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(ScoreTable, ShowsEveryMethodAndWhatOthersReported) {
  const std::vector<std::string> lines = LinesOf(ScoreTable(Example()));
  ASSERT_EQ(lines.size(), 3U + 2U + 5U + 3U);
  EXPECT_EQ(lines[0],
            "1-5: 746 frames, 1 seed, voxels of 20 cm, 0 of them scored: 1000 true, 100 vanished, "
            "50 remembered");
  EXPECT_EQ(
      lines[3],
      "static               |  60.0   75.0   7.41 |  78.0   99.1   4.21 |  79.0   90.0  100.0 "
      "  40.0 |  6.6    -     12.3   0.7");
  EXPECT_TRUE(lines[4].starts_with("fresh ")) << lines[4];
  EXPECT_NE(lines[4].find(" 18.0   20.0 "), std::string::npos) << lines[4];
  EXPECT_TRUE(lines[9].starts_with("POCD                 |  80.2   78.7    3.0 |")) << lines[9];
  EXPECT_TRUE(lines[12].starts_with("static ")) << "fresh has no events: " << lines[12];
}

TEST(EventFaultText, ListsTheFaultsOfMethodsThatObserveChanges) {
  Evaluation evaluation = Example();
  evaluation.rows[0].event_faults = {"missing: departure"};
  evaluation.rows[1].event_faults = {"no fault of a map of one sequence"};
  EXPECT_EQ(EventFaultText(evaluation), "static, faults in the events: 1\n  missing: departure\n");
}

TEST(ScoreTable, LinesOfOneBlockAreAsLong) {
  const std::vector<std::string> lines = LinesOf(ScoreTable(Example()));
  for (const std::size_t line : {2U, 4U}) EXPECT_EQ(lines[3].size(), lines[line].size());
  EXPECT_LE(lines[3].size(), 120U);
  EXPECT_EQ(lines[11].size(), lines[12].size());
}

TEST(ScoreTable, OtherRoutesStandAlone) {
  Evaluation evaluation = Example();
  evaluation.title = "people";
  evaluation.has_history = false;
  EXPECT_EQ(LinesOf(ScoreTable(evaluation)).size(), 5U);
}

TEST(ScoreTable, TheLastLineHoldsTheErrorsOfThePoses) {
  Evaluation evaluation = Example();
  evaluation.claimed_poses = {.square_sum_m2 = 0.03 * 0.03, .points = 1};
  EXPECT_EQ(ScoreTable(evaluation), ScoreTable(Example())) << "no method registers frames";
  evaluation.rows[1].name = "pocd";
  evaluation.rows[1].registered_poses = {.square_sum_m2 = 4 * 0.012 * 0.012,
                                         .points = 4,
                                         .square_sum_sigmas2 = 2 * 6 * 1.5 * 1.5,
                                         .stated_poses = 2};
  EXPECT_EQ(
      LinesOf(ScoreTable(evaluation)).back(),
      "poses                | RMS error, mm: claimed 30.0, pocd registered 12.0 (1.5 sigmas)");
}

TEST(EvaluationJson, HoldsTheCounts) {
  const Json table = Json::parse(IndentedJson(EvaluationJson({Example()}))).at(0);
  const Json& scores = table.at("rows").at(0);
  EXPECT_EQ(scores.at("near").at("wrong_voxels"), 220);
  EXPECT_EQ(scores.at("trail"), Json::parse(R"({"share": 0.4, "part": 4, "whole": 10})"));
  EXPECT_TRUE(scores.at("brier").is_null()) << scores;
  EXPECT_TRUE(scores.at("registered_poses_rms_m").is_null()) << scores;
  EXPECT_EQ(scores.at("stage_ms").at("free_space"), 0);
  EXPECT_EQ(table.at("reported").back().at("method"), "POCD") << table;
}

TEST(SelectMethods, TheYardsticksAreAlwaysThere) {
  const auto methods = SelectMethods({}, MapConfig());
  ASSERT_TRUE(methods.ok()) << methods.status();
  ASSERT_GE(methods->size(), 2U);
  EXPECT_EQ((*methods)[0].name, "static");
  EXPECT_EQ((*methods)[1].name, "fresh");
  EXPECT_TRUE((*methods)[1].last_sequence_only);
  EXPECT_EQ(SelectMethods({"fresh"}, MapConfig())->size(), 2U);
  EXPECT_EQ(SelectMethods({"best"}, MapConfig()).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(StageTable, ShowsEveryStageOfEveryMethod) {
  Evaluation evaluation = Example();
  StageTimes& times = evaluation.rows[0].cost.stage_ms;
  times[static_cast<std::size_t>(MapperStage::kCloud)] = 0.25;
  times[static_cast<std::size_t>(MapperStage::kCommit)] = 1.5;
  const std::vector<std::string> lines = LinesOf(StageTable(evaluation));
  ASSERT_EQ(lines.size(), 3U);
  for (const std::string_view name : kMapperStageNames) {
    EXPECT_NE(lines[0].find(name), std::string::npos) << name;
  }
  EXPECT_TRUE(lines[1].starts_with("static               |  0.250 ")) << lines[1];
  EXPECT_TRUE(lines[1].ends_with(" 1.500 |   1.75")) << lines[1];
  EXPECT_EQ(lines[0].size(), lines[1].size());
  EXPECT_EQ(lines[1].size(), lines[2].size());
}

TEST(StageClock, CountsWhatLiesBetweenEnterAndLeave) {
  StageClock clock;
  clock.Leave();
  EXPECT_TRUE(clock.total_ms() == StageTimes{});
  clock.Enter(MapperStage::kLooks);
  clock.Enter(MapperStage::kCommit);
  clock.Leave();
  const StageTimes once = clock.total_ms();
  clock.Leave();
  EXPECT_TRUE(clock.total_ms() == once) << "no stage was running";
  EXPECT_GE(once[static_cast<std::size_t>(MapperStage::kLooks)], 0.0);
  EXPECT_EQ(once[static_cast<std::size_t>(MapperStage::kCloud)], 0.0);
}

bool HasColor(const Image<Rgb>& picture, const Rgb& color) {
  return std::find(picture.data(), picture.data() + picture.size(), color) !=
         picture.data() + picture.size();
}

TEST(DrawScorePicture, ShowsVerdictsInTheirColours) {
  std::vector<JudgedVoxel> voxels;
  voxels.reserve(4);
  for (int z = 0; z < 4; ++z) voxels.push_back({{0, 0, z}, VoxelVerdict::kWrong});
  const Image<Rgb> picture = DrawScorePicture(voxels, 0.2, {"route, policy", "below"});
  const Image<Rgb> empty = DrawScorePicture({}, 0.2, {"route, policy", "below"});
  EXPECT_GE(picture.width_px(), 500);
  EXPECT_GT(empty.width_px(), 500);
  // The picture is five voxels wide, so the column is at its centre; the legend lies outside.
  const Rgb middle = picture.At(28 + 24 * 5 / 2, 84 + 24 * 5 / 2);
  EXPECT_EQ(middle, (Rgb{213, 80, 0}));
  EXPECT_TRUE(HasColor(empty, {70, 125, 105})) << "the legend";
}

}  // namespace
}  // namespace steadymap

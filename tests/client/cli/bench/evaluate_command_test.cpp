#include "client/cli/bench/evaluate_command.h"

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/cli/command_line.h"
#include "client/cli/text/json_text.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

/// Output and exit code of the command.
struct Outcome {
  int exit_code = 0;
  std::string out;
  std::string err;
};

Outcome Steadymap(const std::vector<std::string>& arguments) {
  std::ostringstream out;
  std::ostringstream err;
  CommandContext context{.out = out, .err = err};
  const int exit_code = RunCommandLine(arguments, &context);
  return {exit_code, out.str(), err.str()};
}

Outcome Evaluate(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "evaluate");
  return Steadymap(arguments);
}

/// Returns the row of a method in the first table that `evaluate` prints, without the last column,
/// which is a time.
std::string RowOf(const std::string& method, const Outcome& outcome) {
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::size_t start = outcome.out.find("\n" + method + " ");
  return outcome.out.substr(start, outcome.out.find('\n', start + 1) - start - 16);
}

/// Returns the table that `evaluate` prints for a few frames of the twin, with further arguments.
std::string TableOfTwin(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--route", "twin", "--stride", "40", "--policy", "static"});
  return RowOf("static", Evaluate(arguments));
}

TEST(EvaluateCommand, PrintsATableAndDrawsAPictureAMethod) {
  const TemporaryFolder folder;
  const std::filesystem::path pictures = folder.path() / "pictures";
  const Outcome outcome =
      Evaluate({"--route", "twin", "--stride", "20", "--ideal", "--pictures", pictures.string()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(outcome.out.starts_with("twin: ")) << outcome.out;
  for (const std::string& method : MethodNames()) {
    EXPECT_NE(outcome.out.find("\n" + method + " "), std::string::npos) << outcome.out;
    EXPECT_TRUE(std::filesystem::exists(pictures / ("twin-" + method + ".png"))) << method;
  }
}

TEST(EvaluateCommand, PrintsJsonInstead) {
  const Outcome outcome = Evaluate({"--route", "twin", "--stride", "30", "--ideal", "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json tables = Json::parse(outcome.out);
  ASSERT_EQ(tables.size(), 1U) << outcome.out;
  EXPECT_EQ(tables[0].at("route"), "twin");
  EXPECT_EQ(tables[0].at("rows").at(0).at("policy"), "static");
}

TEST(EvaluateCommand, TakesParametersOfThePolicies) {
  const std::vector<std::string> defaults = {
      "--route", "twin", "--stride", "10", "--ideal", "--policy", "pocd"};
  std::vector<std::string> blind = defaults;
  blind.insert(blind.end(), {"--set", "min_area_m2=10"});
  EXPECT_NE(RowOf("pocd", Evaluate(blind)), RowOf("pocd", Evaluate(defaults)));
}

TEST(EvaluateCommand, RefusesParametersThatNoPolicyHas) {
  const std::vector<std::vector<std::string>> commands = {
      {"evaluate", "--route", "twin", "--policy", "static"},
      {"evaluate-rooms", "--cases", "1", "--policy", "static"},
      {"evaluate-fleet", "--policy", "static"},
      {"evaluate-composite", "nowhere", "--format", "seven-scenes", "--policy", "static"}};
  for (std::vector<std::string> arguments : commands) {
    SCOPED_TRACE(arguments.front());
    arguments.insert(arguments.end(), {"--set", "max_jump_m=0.1"});
    const Outcome unknown = Steadymap(arguments);
    EXPECT_NE(unknown.exit_code, 0);
    EXPECT_NE(unknown.err.find("max_jump_m"), std::string::npos) << unknown.err;
    arguments.back() = "max_jump_m";
    EXPECT_NE(Steadymap(arguments).err.find("NAME=VALUE"), std::string::npos);
  }
  const Outcome wild = Steadymap({"evaluate-rooms", "--cases", "1", "--set", "max_jump_m=1000000"});
  EXPECT_NE(wild.exit_code, 0);
  EXPECT_NE(wild.err.find("max_jump_m"), std::string::npos) << wild.err;
}

TEST(EvaluateCommand, ALostRobotSpoilsAMapThatFusesEverything) {
  const std::vector<std::string> sound = {
      "--route", "twin", "--stride", "20", "--ideal", "--policy", "static"};
  std::vector<std::string> misled = sound;
  misled.insert(misled.end(), {"--lost", "1", "1000"});
  EXPECT_NE(RowOf("static", Evaluate(misled)), RowOf("static", Evaluate(sound)));
}

TEST(EvaluateCommand, ShowsTheStagesOfPocdAndDrawsItsScores) {
  const TemporaryFolder folder;
  const Outcome outcome = Evaluate({"--route",
                                    "twin",
                                    "--stride",
                                    "40",
                                    "--ideal",
                                    "--policy",
                                    "pocd",
                                    "--stages",
                                    "--pictures",
                                    folder.path().string()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("\npocd "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("\nms/frame "), std::string::npos) << outcome.out;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "twin-pocd.png"));
}

TEST(EvaluateCommand, TheSensorChangesTheScores) {
  const std::string ideal = TableOfTwin({"--ideal"});
  EXPECT_NE(ideal, TableOfTwin({}));
  EXPECT_NE(TableOfTwin({}), TableOfTwin({"--hard"}));
  EXPECT_EQ(Evaluate({"--route", "twin", "--ideal", "--hard"}).exit_code, 2);
}

TEST(EvaluateCommand, VoxelAndMaximumDepthOfTheMapsChangeTheScores) {
  const std::string standard = TableOfTwin({"--ideal"});
  EXPECT_NE(standard, TableOfTwin({"--ideal", "--map-voxel", "0.1"}));
  EXPECT_NE(standard, TableOfTwin({"--ideal", "--max-depth", "1.5"}));
  EXPECT_EQ(standard, TableOfTwin({"--ideal", "--map-voxel", "0.05", "--max-depth", "3"}));
}

TEST(EvaluateCommand, WritesTheMeshOfEachMapAndTheTrueSurface) {
  const TemporaryFolder folder;
  TableOfTwin({"--ideal", "--meshes", folder.path().string()});
  std::size_t meshes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_EQ(entry.path().extension(), ".ply") << entry.path();
    EXPECT_GT(entry.file_size(), 1000U) << entry.path();
    ++meshes;
  }
  EXPECT_GE(meshes, 2U);
}

TEST(EvaluateRoomsCommand, PrintsTheShareOfExactCasesAndTheirFaults) {
  const Outcome outcome =
      Steadymap({"evaluate-rooms", "--change", "added", "--cases", "1", "--faults"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(outcome.out.starts_with("added:")) << outcome.out;
  EXPECT_NE(outcome.out.find("\nadded  "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("\nall  "), std::string::npos) << outcome.out;
}

TEST(EvaluateRoomsCommand, LeavesOutChangesThatCannotBeToldWithTheChosenLabels) {
  const Outcome outcome = Steadymap({"evaluate-rooms",
                                     "--labels",
                                     "none",
                                     "--cases",
                                     "1",
                                     "--change",
                                     "removed-in-view",
                                     "--change",
                                     "swapped-classes",
                                     "--change",
                                     "touching-removed"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("\nremoved-in-view  "), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("swapped-classes"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("touching-removed"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("|            - |       1 of 1 |"), std::string::npos) << outcome.out;
}

TEST(EvaluateRoomsCommand, RefusesAnUnknownChangeOrPolicy) {
  EXPECT_EQ(Steadymap({"evaluate-rooms", "--labels", "some"}).exit_code, 2);
  EXPECT_EQ(Steadymap({"evaluate-rooms", "--change", "painted"}).exit_code, 2);
  EXPECT_EQ(Steadymap({"evaluate-rooms", "--policy", "best"}).exit_code, 2);
  EXPECT_EQ(Steadymap({"evaluate-rooms", "--cases", "0"}).exit_code, 2);
  EXPECT_EQ(Steadymap({"evaluate-rooms", "--variation", "31hz"}).exit_code, 2);
}

TEST(EvaluateRoomsCommand, RefusesVariationsThatNoChangeAllowsTogether) {
  const Outcome outcome =
      Steadymap({"evaluate-rooms", "--variation", "15hz", "--variation", "30hz"});
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_NE(outcome.err.find("no change allows these variations"), std::string::npos)
      << outcome.err;
}

TEST(EvaluateFleetCommand, PrintsARowForEachCase) {
  const Outcome outcome =
      Steadymap({"evaluate-fleet", "--route", "twin", "--case", "newest-first", "--case", "2hz"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("\n2hz  "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("\nnewest-first  "), std::string::npos) << outcome.out;
  EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 3) << outcome.out;
}

TEST(EvaluateFleetCommand, RefusesAnUnknownRouteOrCase) {
  EXPECT_EQ(Steadymap({"evaluate-fleet", "--route", "nowhere"}).exit_code, 2);
  EXPECT_EQ(Steadymap({"evaluate-fleet", "--case", "slow"}).exit_code, 2);
}

TEST(EvaluateCommand, MisuseIsAnErrorThatSaysWhy) {
  EXPECT_EQ(Evaluate({}).exit_code, 1);
  EXPECT_EQ(Evaluate({"--route", "nowhere"}).exit_code, 2);
  EXPECT_EQ(Evaluate({"--route", "twin", "--policy", "best"}).exit_code, 2);
  EXPECT_EQ(Evaluate({"--sequence", "/nowhere"}).exit_code, 2);
  EXPECT_EQ(Evaluate({"--route", "twin", "--lost", "5"}).exit_code, 2);
  EXPECT_EQ(Evaluate({"--format", "tum", "--lost", "5", "3"}).exit_code, 2);
  const Outcome missing = Evaluate({"--format", "tum", "--sequence", "/nowhere"});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_NE(missing.err.find("/nowhere"), std::string::npos) << missing.err;
}

}  // namespace
}  // namespace steadymap

// Tests the map commands of the command line against a daemon.

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/map/map_client.h"
#include "tests/contract/cli_fixture.h"

namespace steadymap {
namespace {

const MapName kLabelled{"default", "depot"};

class MapCommandTest : public CliTest {
 protected:
  v1::Map Depot() const {
    return MapClient(OpenChannel(daemon_.address())).GetMap(kLabelled).value_or(v1::Map());
  }

  void ExpectSuccess(const std::vector<std::string>& arguments) const {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  }

  void ExpectPart(const std::vector<std::string>& arguments, const std::string& part) const {
    const std::string out = Run(arguments).out;
    EXPECT_NE(out.find(part), std::string::npos) << out;
  }

  std::string WriteFile(const std::string& name, const std::string& content) const {
    std::ofstream(PathOf(name)) << content;
    return PathOf(name);
  }
};

TEST_F(MapCommandTest, LabelsAndWorldFrameAreGivenAtCreationAndShown) {
  ExpectSuccess({"map",
                 "create",
                 "depot",
                 "--label",
                 "site=north",
                 "--label",
                 "formula=a=b",
                 "--world-frame",
                 "Origin at gate 3, x along the dock"});
  ExpectPart({"map", "get", "depot"}, "labels        formula=a=b, site=north\n");
  ExpectPart({"map", "get", "depot"}, "world frame   Origin at gate 3, x along the dock\n");
  ExpectPart({"map", "get", "depot"}, "condition     ready\n");
  ExpectPart({"map", "list"}, "  ready\n  labels: formula=a=b, site=north\n");
  ExpectPart({"map", "list"}, "  world frame: Origin at gate 3, x along the dock\n");
  const Json map = Run({"map", "get", "depot", "--json"}).Document();
  EXPECT_EQ(map.at("labels"), Json::parse(R"({"formula": "a=b", "site": "north"})"));
  EXPECT_EQ(map.at("world_frame").at("description"), "Origin at gate 3, x along the dock");
  EXPECT_EQ(map.at("state").at("condition"), "ready");
  EXPECT_EQ(map.at("state").at("integrated_map_seq"), 0);
  EXPECT_EQ(Run({"map", "list", "--json"}).Document().at("maps").at(0), map);
}

TEST_F(MapCommandTest, UpdateChangesWhatIsNamedAndNothingElse) {
  ExpectSuccess({"map",
                 "create",
                 "depot",
                 "--label",
                 "site=north",
                 "--label",
                 "shift=day",
                 "--world-frame",
                 "Gate 3"});
  ExpectSuccess(
      {"map", "update", "depot", "--label", "shift=", "--label", "a=1", "--remove-label", "site"});
  v1::Map map = Depot();
  EXPECT_EQ(map.labels_size(), 2);
  EXPECT_EQ(map.labels().at("shift"), "");
  EXPECT_EQ(map.labels().at("a"), "1");
  EXPECT_EQ(map.world_frame().description(), "Gate 3");
  ExpectSuccess({"map", "update", "depot", "--world-frame", "Gate 4", "--remove-label", "site"});
  map = Depot();
  EXPECT_EQ(map.labels_size(), 2);
  EXPECT_EQ(map.world_frame().description(), "Gate 4");
  const Outcome updated = Run({"map", "update", "depot", "--label", "a=2", "--json"});
  EXPECT_EQ(updated.Document().at("labels").at("a"), "2");
}

TEST_F(MapCommandTest, ClassesAreAddedAndNoneIsChanged) {
  const std::string first = WriteFile("first.txt", "0 rest background\n7 box semi-static\n");
  ExpectSuccess({"map", "create", "depot", "--classes", first});
  const std::string more = WriteFile("more.txt", "7 box semi-static\n9 person dynamic\n");
  ExpectSuccess({"map", "update", "depot", "--classes", more});
  ASSERT_EQ(Depot().config().classes_size(), 3);
  EXPECT_EQ(Depot().config().classes(2).name(), "person");
  ExpectSuccess({"map", "update", "depot", "--classes", more});
  EXPECT_EQ(Depot().config().classes_size(), 3);
  ExpectFailure({"map", "update", "depot", "--classes", WriteFile("other.txt", "7 crate static\n")},
                "the row of class 7, \"box\", must remain unchanged [BAD_VALUE, "
                "map.config.classes]");
  EXPECT_EQ(Depot().config().classes_size(), 3);
  ExpectFailure({"map", "update", "depot", "--classes", PathOf("missing.txt")}, "missing.txt");
}

TEST_F(MapCommandTest, ImpossibleChangesAreRefusedWithTheirReason) {
  ExpectFailure({"map", "create", "depot", "--label", "Site=north"}, "map.labels");
  ExpectFailure({"map", "create", "depot", "--label", "site"}, "KEY=VALUE");
  ExpectSuccess({"map", "create", "depot", "--label", "site=north"});
  const std::string etag = Depot().etag();
  ExpectFailure({"map", "update", "depot", "--label", "Site=south"}, "[BAD_VALUE, map.labels");
  ExpectFailure({"map", "update", "depot", "--label", "=south"}, "KEY=VALUE");
  ExpectFailure({"map", "update", "depot", "--label", "site=a", "--label", "site=b"}, "site=b");
  ExpectFailure({"map", "update", "depot", "--label", "site=a", "--remove-label", "site"},
                "\"site\"");
  ExpectFailure({"map", "update", "depot", "--world-frame", std::string(513, 'w')},
                "map.world_frame.description");
  ExpectFailure({"map", "update", "depot"}, "--label");
  ExpectFailure({"map", "update", "nowhere", "--label", "site=south"}, "NOT_FOUND");
  EXPECT_EQ(Depot().etag(), etag) << "nothing was changed";
}

TEST_F(MapCommandTest, AnEtagGuardsAChange) {
  ExpectSuccess({"map", "create", "depot"});
  const std::string etag = Depot().etag();
  ExpectSuccess({"map", "update", "depot", "--label", "a=1", "--etag", etag});
  ExpectFailure({"map", "update", "depot", "--label", "a=2", "--etag", etag}, "ETAG_MISMATCH");
  EXPECT_EQ(Depot().labels().at("a"), "1");
}

TEST_F(MapCommandTest, ADamagedMapIsListedWithTheReason) {
  ExpectSuccess({"map", "create", "depot"});
  daemon_.Kill();
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "data" / "maps")) {
    std::filesystem::remove_all(entry.path());
  }
  daemon_.Restart();
  ExpectSuccess({"map", "create", "hall"});
  const std::string list = Run({"map", "list"}).out;
  EXPECT_NE(list.find("  damaged: "), std::string::npos) << list;
  EXPECT_NE(list.find("is missing"), std::string::npos) << list;
  EXPECT_NE(list.find("  ready\n"), std::string::npos) << list;
  const Json maps = Run({"map", "list", "--json"}).Document().at("maps");
  EXPECT_EQ(maps.at(0).at("state").at("condition"), "damaged");
  ExpectFailure({"map", "update", "depot", "--label", "a=1"}, "is missing");
}

}  // namespace
}  // namespace steadymap

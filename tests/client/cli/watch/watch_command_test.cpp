// Tests `steadymap watch` and `steadymap mirror` against a scripted server.

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/cli/command_line.h"
#include "client/cli/text/json_text.h"
#include "client/cli/watch/resume_token.h"
#include "core/query/vdb_file.h"
#include "core/types/error.h"
#include "proto/grpc_status.h"
#include "tests/client/map/fake_map_server.h"
#include "tests/client/watch/fake_watch_service.h"
#include "tests/client/watch/watch_messages.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using watching::Created;
using watching::DeltaOf;
using watching::Events;
using watching::FirstMap;
using watching::Join;
using watching::Messages;
using watching::Progress;
using watching::Resync;
using watching::SecondMap;
using watching::SnapshotOf;

/// Output and exit code of a watch.
struct WatchOutcome {
  int exit_code = 0;
  std::string out;
  std::string err;

  bool Says(const std::string& part) const { return out.find(part) != std::string::npos; }

  std::vector<std::string> Lines() const {
    std::vector<std::string> lines;
    std::istringstream stream(out);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }

  /// Returns the lines, each parsed as a JSON document.
  std::vector<Json> Documents() const {
    std::vector<Json> documents;
    for (const std::string& line : Lines()) documents.push_back(Json::parse(line));
    return documents;
  }
};

class WatchCommandTest : public ::testing::Test {
 public:
  ~WatchCommandTest() override { watches_.Release(); }

 protected:
  WatchCommandTest() {
    v1::Map& map = maps_.maps["tenants/default/maps/kitchen"];
    map.set_name("tenants/default/maps/kitchen");
    v1::SemanticClass& chair = *map.mutable_config()->add_classes();
    chair.set_id(103);
    chair.set_name("chair");
  }

  WatchOutcome Run(const std::vector<std::string>& arguments) {
    std::ostringstream out;
    std::ostringstream err;
    CommandContext context{.out = out, .err = err};
    context.open_channel = [this](const std::string&) { return server_.channel(); };
    const int exit_code = RunCommandLine(arguments, &context);
    return {exit_code, out.str(), err.str()};
  }

  void ExpectRefused(const std::vector<std::string>& arguments,
                     int exit_code,
                     const std::string& part) {
    const WatchOutcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    EXPECT_TRUE(watches_.requests().empty());
  }

  /// Plays scripts that send messages and leave the stream open.
  void Play(const std::vector<Messages>& streams) {
    std::vector<FakeWatchService::Script> scripts;
    scripts.reserve(streams.size());
    for (const Messages& messages : streams) {
      scripts.emplace_back([messages](ScriptedWatch& watch) {
        watch.Send(messages);
        return watch.Hold();
      });
    }
    watches_.SetScripts(scripts);
  }

  std::string PathOf(const std::string& name) const { return (folder_.path() / name).string(); }

  std::string ContentOf(const std::string& name) const {
    std::ifstream stream(PathOf(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }

  const MapSnapshot first_ = FirstMap();
  const MapSnapshot second_ = SecondMap();
  const Messages snapshot_ = Join({Created(first_), SnapshotOf(first_), Progress(5, "t5")});
  const Messages step_ = Join({DeltaOf(first_, second_, 2), Events(6, {1}), Progress(6, "t6")});
  TemporaryFolder folder_;
  FakeMapService maps_;
  FakeWatchService watches_;
  FakeServer server_{&maps_, &watches_};
};

TEST_F(WatchCommandTest, HelpTellsOfBoth) {
  EXPECT_TRUE(Run({"watch", "--help"}).Says("--token-file"));
  EXPECT_TRUE(Run({"mirror", "--help"}).Says("mirror.json"));
}

TEST_F(WatchCommandTest, FiltersAreSent) {
  Play({Created(first_)});
  const WatchOutcome outcome = Run({"watch",
                                    "kitchen",
                                    "--class",
                                    "chair",
                                    "--class",
                                    "9",
                                    "--box",
                                    "0,0,0,1,2,3",
                                    "--box",
                                    "-1,-1,-1,0,0,0",
                                    "--object",
                                    "4",
                                    "--kinds",
                                    "events,volume",
                                    "--archived",
                                    "--until-revision",
                                    "5"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const v1::WatchMapRequest request = watches_.requests().at(0);
  EXPECT_EQ(request.map(), "tenants/default/maps/kitchen");
  EXPECT_EQ(request.start(), v1::WATCH_START_NOW);
  const v1::WatchFilter& filter = request.filter();
  ASSERT_EQ(filter.class_ids_size(), 2);
  EXPECT_EQ(filter.class_ids(0), 9U);
  EXPECT_EQ(filter.class_ids(1), 103U);
  ASSERT_EQ(filter.boxes_size(), 2);
  EXPECT_EQ(filter.boxes(0).max_m().z(), 3.0);
  EXPECT_EQ(filter.object_ids(0), 4U);
  ASSERT_EQ(filter.kinds_size(), 2);
  EXPECT_EQ(filter.kinds(0), v1::WATCH_KIND_EVENTS);
  EXPECT_EQ(filter.kinds(1), v1::WATCH_KIND_VOLUMES);
  EXPECT_TRUE(filter.include_archived());
}

TEST_F(WatchCommandTest, JsonIsADocumentALine) {
  Play({Join({snapshot_, step_})});
  const WatchOutcome outcome =
      Run({"watch", "kitchen", "--from", "snapshot", "--json", "--count", "2"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::vector<Json> lines = outcome.Documents();
  ASSERT_EQ(lines.size(), 11U) << outcome.out;
  for (const Json& line : lines) EXPECT_EQ(line.begin().key(), "kind") << line;
  EXPECT_EQ(lines[0].at("kind"), "created");
  EXPECT_EQ(lines[0].at("revision"), 5);
  EXPECT_EQ(lines[0].at("voxel_size_m"), 0.05);
  EXPECT_EQ(lines[1].at("kind"), "object");
  EXPECT_EQ(lines[1].at("revision"), 5);
  EXPECT_EQ(lines[1].at("object").at("id"), 1);
  EXPECT_EQ(lines[3].at("kind"), "volume");
  EXPECT_EQ(lines[3].at("revision"), 5);
  EXPECT_EQ(lines[4], Json::parse(R"({
    "kind": "progress", "revision": 5, "previous_revision": 5, "commits": 0, "snapshot": true,
    "resume_token": "dDU"
  })"));
  EXPECT_EQ(lines[5], Json::parse(R"({"kind": "removed", "revision": 6, "object": 1})"));
  EXPECT_EQ(lines[7].at("object").at("class_name"), "chair");
  EXPECT_EQ(lines[8].at("kind"), "event");
  EXPECT_EQ(lines[8].at("event").at("number"), 1);
  EXPECT_EQ(lines[9].at("last_capture_time"), 60);
  EXPECT_EQ(lines[9].at("leaves")[0], Json::parse(R"({"object": 0, "changed": 1, "gone": 1})"));
  EXPECT_EQ(lines[10].at("resume_token"), "dDY");
}

TEST_F(WatchCommandTest, PeopleGetTheSameInWords) {
  Play({Join({snapshot_, step_})});
  const WatchOutcome outcome =
      Run({"watch", "kitchen", "--from", "snapshot", "--until-revision", "6"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(outcome.Says("object    object 3 (chair) present at (1.00, 0.50, 0.60)"))
      << outcome.out;
  EXPECT_TRUE(outcome.Says("removed   object 1 is no longer shown\n"));
  EXPECT_TRUE(outcome.Says("2 leaves of the background"));
  EXPECT_TRUE(outcome.Says("progress  revision 6, token dDY\n"));
}

TEST_F(WatchCommandTest, AStepThatBreaksOffIsNotPrinted) {
  const Messages cut = Join({snapshot_, Events(6, {1}), {DeltaOf(first_, second_, 2)[0]}});
  watches_.SetScripts({[&](ScriptedWatch& watch) {
                         watch.Send(cut);
                         return ToGrpcStatus(MakeError(
                             absl::StatusCode::kUnavailable, reason::kDraining, "going down"));
                       },
                       [&](ScriptedWatch& watch) {
                         watch.Send(Join({Created(first_), step_}));
                         return watch.Hold();
                       }});
  const WatchOutcome outcome =
      Run({"watch", "kitchen", "--from", "snapshot", "--json", "--until-revision", "6"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.Lines().size(), 11U) << outcome.out;
  EXPECT_NE(outcome.err.find("going down [DRAINING]"), std::string::npos) << outcome.err;
  EXPECT_EQ(watches_.requests().at(1).resume_token(), "t5");
}

TEST_F(WatchCommandTest, AResyncIsSaidBeforeWhatFollows) {
  Play({Join({snapshot_, Resync(6), SnapshotOf(second_), Progress(6, "t6")})});
  const WatchOutcome outcome =
      Run({"watch", "kitchen", "--from", "snapshot", "--json", "--until-revision", "6"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::vector<Json> lines = outcome.Documents();
  ASSERT_GT(lines.size(), 5U);
  EXPECT_EQ(lines[5],
            Json::parse(R"({"kind": "resync", "revision": 6, "reason": "REVISION_COMPACTED"})"));
}

TEST_F(WatchCommandTest, TheTokenFileIsKeptAndGoneOnFrom) {
  Play({snapshot_, Join({Created(first_), step_})});
  const std::string file = PathOf("token");
  ASSERT_EQ(Run({"watch", "kitchen", "--from", "snapshot", "--count", "1", "--token-file", file})
                .exit_code,
            0);
  EXPECT_EQ(ContentOf("token"), "dDU\n");
  ASSERT_EQ(Run({"watch", "kitchen", "--count", "1", "--token-file", file}).exit_code, 0);
  EXPECT_EQ(watches_.requests().at(1).resume_token(), "t5");
  EXPECT_EQ(watches_.requests().at(1).start(), v1::WATCH_START_UNSPECIFIED);
  EXPECT_EQ(ContentOf("token"), "dDY\n");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1)
      << "no temporary file is left";
}

TEST_F(WatchCommandTest, ATokenIsGoneOnFrom) {
  Play({Join({Created(first_), step_})});
  EXPECT_EQ(Run({"watch", "kitchen", "--from", "dDU", "--count", "1"}).exit_code, 0);
  EXPECT_EQ(watches_.requests().at(0).resume_token(), "t5");
}

TEST_F(WatchCommandTest, TwoStartsMustAgree) {
  ASSERT_TRUE(WriteTokenFile(PathOf("token"), "t5").ok());
  const std::string file = PathOf("token");
  ExpectRefused({"watch", "kitchen", "--token-file", file, "--from", "now"}, 1, file);
  ExpectRefused({"watch", "kitchen", "--token-file", file, "--from", "snapshot"}, 1, file);
  ExpectRefused({"watch", "kitchen", "--token-file", file, "--from", "dDY"}, 1, file);
  Play({Join({Created(first_), step_})});
  EXPECT_EQ(
      Run({"watch", "kitchen", "--token-file", file, "--from", "dDU", "--count", "1"}).exit_code,
      0);
}

TEST_F(WatchCommandTest, WhatMakesNoSenseIsRefusedBeforeAnythingIsWatched) {
  std::ofstream(PathOf("garbage")) << "no token!";
  std::ofstream(PathOf("empty")) << "";
  std::ofstream(PathOf("long")) << std::string(5000, 'A');
  for (const char* file : {"garbage", "empty", "long"}) {
    ExpectRefused({"watch", "kitchen", "--token-file", PathOf(file)}, 1, "a resume token");
  }
  ExpectRefused({"watch", "kitchen", "--from", "yesterday!"}, 1, "\"yesterday!\"");
  ExpectRefused({"watch", "kitchen", "--class", "dragon"}, 1, "\"dragon\"");
  ExpectRefused({"watch", "kitchen", "--box", "1,2,3"}, 1, "a box");
  ExpectRefused({"watch", "kitchen", "--kinds", "gossip"}, 2, "gossip");
  ExpectRefused({"watch", "kitchen", "--count", "0"}, 2, "--count");
  ExpectRefused({"watch", "attic"}, 1, "there is no map");
  ExpectRefused({"watch"}, 2, "NAME");
  ExpectRefused({"mirror", "kitchen"}, 2, "--output");
  ExpectRefused({"mirror", "attic", "--output", PathOf("folder")}, 1, "there is no map");
  ExpectRefused(
      {"mirror", "kitchen", "--output", PathOf("f"), "--interval", "-1"}, 2, "--interval");
  ExpectRefused({"mirror", "kitchen", "--output", PathOf("garbage")}, 1, "garbage");
}

TEST_F(WatchCommandTest, WhatEndsAWatchIsTheError) {
  watches_.SetScripts({[](ScriptedWatch&) {
    return ToGrpcStatus(MakeError(
        absl::StatusCode::kInvalidArgument, reason::kBadResumeToken, "not yours", "resume_token"));
  }});
  const WatchOutcome outcome = Run({"watch", "kitchen", "--from", "dDU"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err, "steadymap: not yours [BAD_RESUME_TOKEN, resume_token]\n");
}

TEST_F(WatchCommandTest, SignalsEndAWatchWithItsTokenKept) {
  for (const int signal : {SIGTERM, SIGINT}) {
    watches_.SetScripts({[&](ScriptedWatch& watch) {
      watch.Send(snapshot_);
      std::raise(signal);
      return watch.Hold();
    }});
    std::filesystem::remove(PathOf("token"));
    const WatchOutcome outcome =
        Run({"watch", "kitchen", "--from", "snapshot", "--token-file", PathOf("token")});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.Says("token dDU"), ContentOf("token") == "dDU\n") << outcome.out;
  }
}

TEST_F(WatchCommandTest, AMirrorWritesTheMapAndWhatItIs) {
  Play({snapshot_});
  const WatchOutcome outcome = Run({"mirror", "kitchen", "--output", PathOf("a/b"), "--once"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.Lines().size(), 1U);
  EXPECT_TRUE(outcome.Says("revision 5 of tenants/default/maps/kitchen")) << outcome.out;
  EXPECT_EQ(ContentOf("a/b/map.vdb"), *WriteVdb(first_, nullptr));
  const Json state = Json::parse(ContentOf("a/b/mirror.json"));
  EXPECT_EQ(state.at("revision"), 5);
  EXPECT_EQ(state.at("objects"), 2);
  EXPECT_EQ(state.at("resume_token"), "dDU");
  const v1::WatchMapRequest request = watches_.requests().at(0);
  EXPECT_EQ(request.start(), v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
  EXPECT_EQ(request.filter().kinds_size(), 2) << "no events";
}

TEST_F(WatchCommandTest, AStoppedMirrorIsAsNewAsItGot) {
  watches_.SetScripts({[&](ScriptedWatch& watch) {
    watch.Send(Join({snapshot_, step_}));
    std::raise(SIGTERM);
    return watch.Hold();
  }});
  const WatchOutcome outcome =
      Run({"mirror", "kitchen", "--output", PathOf("m"), "--interval", "1000"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LE(outcome.Lines().size(), 2U) << "the first at once, the last at the end";
  const std::string file = ContentOf("m/map.vdb");
  EXPECT_TRUE(file.empty() || file == *WriteVdb(first_, nullptr) ||
              file == *WriteVdb(second_, nullptr));
}

TEST_F(WatchCommandTest, AMirrorOfSomeObjectsHasNoBackground) {
  MapSnapshot objects = first_;
  objects.background = Background();
  Play({Join({Created(objects), SnapshotOf(objects), Progress(5, "t5")})});
  const WatchOutcome outcome = Run(
      {"mirror", "kitchen", "--output", PathOf("m"), "--once", "--object", "1", "--object", "2"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  std::vector<PlacedVolume> volumes = ShownVolumes(first_);
  volumes.erase(volumes.begin());
  EXPECT_EQ(ContentOf("m/map.vdb"), *WriteVdb(first_, volumes, nullptr));
}

TEST(ResumeTokenText, ReadsBackWhateverTheToken) {
  std::string token;
  for (int byte = 0; byte < 256; ++byte) {
    token += static_cast<char>(byte);
    const std::string text = ResumeTokenText(token);
    EXPECT_EQ(text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                     "0123456789-_"),
              std::string::npos);
    ASSERT_EQ(*ParseResumeToken(text), token);
  }
  EXPECT_FALSE(ParseResumeToken("").ok());
}

}  // namespace
}  // namespace steadymap

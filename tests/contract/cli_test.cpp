#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/bench/simulator/simulated_frame_source.h"
#include "client/map/map_client.h"
#include "client/transport/channel.h"
#include "client/upload/uploader.h"
#include "tests/contract/cli_fixture.h"

namespace steadymap {
namespace {

const MapName kHall{"default", "hall"};

/// Returns whether an entry of `list` has this member.
bool Has(const Json& list, const std::string& key, const std::string& value) {
  return std::any_of(
      list.begin(), list.end(), [&](const Json& entry) { return entry.at(key) == value; });
}

class CliFileTest : public CliTest {
 protected:
  std::string HeadOf(const std::string& name, std::size_t size) const {
    std::string head(size, '\0');
    std::ifstream(PathOf(name)).read(head.data(), static_cast<std::streamsize>(size));
    return head;
  }

  /// Returns the first vertex of a PLY file in the command line's point format.
  std::string FirstVertex(const std::string& name) const {
    std::ifstream stream(PathOf(name), std::ios::binary);
    for (std::string line; line != "end_header";) {
      if (!std::getline(stream, line)) return "no header";
    }
    std::array<float, 3> vertex{};
    stream.read(reinterpret_cast<char*>(vertex.data()), sizeof(vertex));
    std::ostringstream text;
    text << vertex[0] << ',' << vertex[1] << ',' << vertex[2];
    return text.str();
  }
};

TEST_F(CliTest, MapsAreCreatedListedShownAndDeleted) {
  EXPECT_EQ(Run({"map", "create", "kitchen", "--voxel-size", "0.02"}).exit_code, 0);
  EXPECT_EQ(Run({"map", "create", "attic"}).exit_code, 0);
  const Outcome list = Run({"map", "list"});
  EXPECT_LT(list.out.find("maps/attic"), list.out.find("maps/kitchen"));
  const Json kitchen = Run({"map", "get", "kitchen", "--json"}).Document();
  EXPECT_EQ(kitchen.at("config").at("voxel_size_m"), 0.02);
  ExpectFailure({"map", "create", "kitchen"}, "ALREADY_EXISTS");
  EXPECT_EQ(Run({"map", "delete", "kitchen"}).exit_code, 0);
  ExpectFailure({"map", "get", "kitchen"}, "NOT_FOUND");
}

TEST_F(CliTest, UnknownMapsAndImpossibleOnesAreErrorsOfOneLine) {
  ExpectFailure({"map", "delete", "nowhere"}, "NOT_FOUND");
  ExpectFailure({"query", "nowhere", "--point", "0,0,0"}, "NOT_FOUND");
  ExpectFailure({"export", "nowhere", "--format", "ply", "--output", PathOf("x.ply")}, "NOT_FOUND");
  ExpectFailure({"render", "nowhere", "--output", PathOf("x.png")}, "NOT_FOUND");
  ExpectFailure({"map", "create", "k", "--voxel-size", "1e9"}, "voxel_size_m");
  EXPECT_FALSE(std::filesystem::exists(PathOf("x.ply")));
}

TEST_F(CliFileTest, ASimulatedRouteIsMappedQueriedExportedAndDrawn) {
  ASSERT_EQ(Run({"map", "create", "hall"}).exit_code, 0);
  const Outcome upload =
      Run({"simulate", "hall", "--route", "baseline", "--ideal", "--stride", "10", "--json"});
  ASSERT_EQ(upload.exit_code, 0) << upload.err;
  EXPECT_EQ(upload.Document().at("refused_count"), 0) << upload.out;

  const Outcome nowhere = Run({"query", "hall", "--point", "1000,0,0"});
  EXPECT_EQ(nowhere.exit_code, 0) << nowhere.err;
  EXPECT_NE(nowhere.out.find("unknown"), std::string::npos) << nowhere.out;

  for (const char* format : {"ply", "vdb", "glb"}) {
    const Outcome outcome = Run(
        {"export", "hall", "--format", format, "--output", PathOf(std::string("map.") + format)});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  EXPECT_EQ(HeadOf("map.ply", 4), "ply\n");
  EXPECT_EQ(HeadOf("map.vdb", 4), " BDV");
  EXPECT_EQ(HeadOf("map.glb", 4), "glTF");
  const Json answer =
      Run({"query", "hall", "--point", FirstVertex("map.ply"), "--json"}).Document();
  EXPECT_NEAR(answer.at("samples").at(0).at("distance_m").get<double>(), 0.0, 0.01)
      << "a vertex of the surface lies within a fifth of a voxel of it";

  const std::uintmax_t whole = std::filesystem::file_size(PathOf("map.ply"));
  EXPECT_GT(whole, 100'000U);
  EXPECT_EQ(Run({"export",
                 "hall",
                 "--format",
                 "ply",
                 "--output",
                 PathOf("part.ply"),
                 "--box",
                 "-1,-1,-1,1,1,1"})
                .exit_code,
            0);
  EXPECT_LT(std::filesystem::file_size(PathOf("part.ply")), whole);

  EXPECT_EQ(Run({"render", "hall", "--output", PathOf("map.png")}).exit_code, 0);
  EXPECT_EQ(HeadOf("map.png", 4), "\x89PNG");
}

TEST_F(CliTest, ObjectsOfAChangedPlaceAreListedExportedAndDrawnAndSurviveAKill) {
  ASSERT_EQ(Run({"map", "create", "depot", "--policy", "pocd"}).exit_code, 0);
  const Outcome upload = Run({"simulate", "depot", "--route", "1-5", "--stride", "6", "--json"});
  ASSERT_EQ(upload.exit_code, 0) << upload.err;
  const Json depot = Run({"map", "get", "depot", "--json"}).Document();
  EXPECT_EQ(depot.at("config").at("policy"), "pocd");

  const Outcome objects = Run({"objects", "depot", "--all", "--json"});
  ASSERT_EQ(objects.exit_code, 0) << objects.err;
  const Json object_list = objects.Document().at("objects");
  EXPECT_TRUE(Has(object_list, "standing", "present")) << objects.out;
  EXPECT_TRUE(Has(object_list, "standing", "archived")) << objects.out;
  EXPECT_EQ(Run({"objects", "depot"}).out.find("archived"), std::string::npos);
  const Outcome events = Run({"events", "depot", "--json"});
  ASSERT_EQ(events.exit_code, 0) << events.err;
  const Json event_list = events.Document().at("events");
  EXPECT_TRUE(Has(event_list, "type", "created")) << events.out;
  EXPECT_TRUE(Has(event_list, "type", "removed")) << events.out;
  const Outcome removed = Run({"events", "depot", "--type", "removed"});
  EXPECT_NE(removed.out.find("removed"), std::string::npos) << removed.out;
  EXPECT_EQ(removed.out.find("created"), std::string::npos) << removed.out;

  const std::string all = Run({"events", "depot"}).out;
  const std::string last = all.substr(all.rfind('\n', all.size() - 2) + 1);
  const std::size_t time_place = last.find('-') - 4;  // Year of the time, 2021-...
  const std::string time = last.substr(time_place, last.find('Z') + 1 - time_place);
  const std::string before = Run({"events", "depot", "--until", time}).out;
  const std::string after = Run({"events", "depot", "--since", time}).out;
  EXPECT_TRUE(after.ends_with(last)) << after;
  EXPECT_EQ(before.find(time), std::string::npos) << before;
  EXPECT_EQ(before + after, all);
  ExpectFailure({"events", "depot", "--since", time, "--until", "2000-01-01T00:00:00Z"},
                "end_time");

  const auto export_size = [this](const std::string& file, const std::string& object) {
    std::vector<std::string> command = {
        "export", "depot", "--format", "vdb", "--output", PathOf(file)};
    if (!object.empty()) command.insert(command.end(), {"--object", object});
    const Outcome outcome = Run(command);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return std::filesystem::file_size(PathOf(file));
  };
  const auto id = object_list.at(0).at("id").get<std::uint64_t>();
  EXPECT_LT(export_size("one.vdb", std::to_string(id)), export_size("all.vdb", ""));
  ExpectFailure(
      {"export", "depot", "--format", "vdb", "--output", PathOf("x.vdb"), "--object", "999999"},
      "NOT_FOUND");
  EXPECT_EQ(Run({"render", "depot", "--output", PathOf("depot.png")}).exit_code, 0);

  daemon_.Kill();
  daemon_.Restart();
  EXPECT_EQ(Run({"objects", "depot", "--all", "--json"}).out, objects.out);
  EXPECT_EQ(Run({"events", "depot", "--json"}).out, events.out);
}

TEST_F(CliTest, ASessionThatIsRepeatedCountsOnce) {
  ASSERT_EQ(Run({"map", "create", "twin"}).exit_code, 0);
  const std::vector<std::string> command = {
      "simulate", "twin", "--route", "twin", "--stride", "10", "--session", "s-1", "--json"};
  const Outcome first = Run(command);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const Outcome second = Run(command);
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(second.Document().at("bytes_sent"), 0) << second.out;
  const Json state = Run({"map", "get", "twin", "--json"}).Document().at("state");
  EXPECT_NE(first.Document().at("revision"), 0);
  EXPECT_EQ(second.Document().at("revision"), first.Document().at("revision"));
  EXPECT_EQ(first.Document().at("revision"), state.at("revision"));
}

TEST_F(CliTest, AnUploadResumesAfterAKilledDaemon) {
  MapClient client(OpenChannel(daemon_.address()));
  ASSERT_TRUE(client.CreateMap(kHall, {}).ok());
  const auto source = SimulatedFrameSource::Open("twin", {.stride = 4});
  ASSERT_TRUE(source.ok()) << source.status();
  const std::size_t frame_count = (*source)->frame_count();
  UploaderOptions options;
  // One frame at a time, so that the kill happens in the middle.
  options.max_buffered_bytes = 1;
  std::atomic<bool> killed = false;
  options.on_progress = [&](const UploadProgress& progress) {
    if (progress.durable < frame_count / 2 || killed.exchange(true)) return;
    daemon_.Kill();
    daemon_.Restart();
  };
  FrameUploader uploader(ChannelsTo(daemon_.address()), kHall, options);
  const absl::StatusOr<UploadSummary> summary = UploadAll(source->get(), &uploader);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_TRUE(killed);
  EXPECT_GE(summary->progress.reconnections, 1U);
  EXPECT_EQ(summary->progress.integrated, frame_count);
  const absl::StatusOr<v1::Map> map = client.GetMap(kHall);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->state().revision(), frame_count);
}

}  // namespace
}  // namespace steadymap

#include <array>
#include <atomic>
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
  EXPECT_NE(Run({"map", "get", "kitchen", "--json"}).out.find("\"voxel_size_m\": 0.02"),
            std::string::npos);
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
  EXPECT_NE(upload.out.find("\"refused_count\": 0"), std::string::npos) << upload.out;

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
  const std::string answer =
      Run({"query", "hall", "--point", FirstVertex("map.ply"), "--json"}).out;
  const std::string key = "\"distance_m\": ";
  ASSERT_NE(answer.find(key), std::string::npos) << answer;
  EXPECT_NEAR(std::stod(answer.substr(answer.find(key) + key.size())), 0.0, 0.01)
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
  EXPECT_NE(Run({"map", "get", "depot", "--json"}).out.find("\"policy\": \"pocd\""),
            std::string::npos);

  const Outcome objects = Run({"objects", "depot", "--all", "--json"});
  ASSERT_EQ(objects.exit_code, 0) << objects.err;
  EXPECT_NE(objects.out.find("\"standing\": \"present\""), std::string::npos) << objects.out;
  EXPECT_NE(objects.out.find("\"standing\": \"archived\""), std::string::npos) << objects.out;
  EXPECT_EQ(Run({"objects", "depot"}).out.find("archived"), std::string::npos);
  const Outcome events = Run({"events", "depot", "--json"});
  ASSERT_EQ(events.exit_code, 0) << events.err;
  EXPECT_NE(events.out.find("\"type\": \"created\""), std::string::npos) << events.out;
  EXPECT_NE(events.out.find("\"type\": \"removed\""), std::string::npos) << events.out;
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
  const std::size_t id_place = objects.out.find("\"id\": ") + 6;
  const std::string id = objects.out.substr(id_place, objects.out.find(',', id_place) - id_place);
  EXPECT_LT(export_size("one.vdb", id), export_size("all.vdb", ""));
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
  EXPECT_NE(second.out.find("\"bytes_sent\": 0"), std::string::npos) << second.out;
  const auto revision = [](const std::string& json) {
    return json.substr(json.find("\"revision\""));
  };
  const std::string state = Run({"map", "get", "twin", "--json"}).out;
  EXPECT_NE(revision(first.out), "\"revision\": 0\n}\n");
  EXPECT_EQ(revision(second.out), revision(first.out));
  EXPECT_EQ(revision(first.out).substr(0, revision(first.out).find('\n')) + ",",
            revision(state).substr(0, revision(state).find('\n')));
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

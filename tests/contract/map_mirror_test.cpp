// Tests mirrors of a real daemon's maps: at every comparable revision they equal the daemon's
// export, bit for bit.

#include "client/map/map_mirror.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/cli/command_line.h"
#include "client/map/map_client.h"
#include "client/transport/channel.h"
#include "core/query/map_mesh.h"
#include "core/query/mesh_file.h"
#include "core/query/vdb_file.h"
#include "proto/convert_event.h"
#include "tests/support/command_outcome.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using std::chrono::milliseconds;

/// Reached only if a test hangs.
constexpr milliseconds kMirrorTimeout{120'000};

const MapName kDepot{"default", "depot"};

class MirrorContractTest : public ::testing::Test {
 protected:
  MirrorContractTest() {
    EXPECT_EQ(Run({"map", "create", "depot", "--policy", "pocd"}), 0) << err_;
  }

  int Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--server", daemon_.address()});
    const Outcome outcome = RunCommand(arguments, OpenChannel);
    out_ = outcome.out;
    err_ = outcome.err;
    return outcome.exit_code;
  }

  /// Returns the lines of the last output, each parsed as a JSON document.
  std::vector<Json> Documents() const {
    std::vector<Json> documents;
    std::istringstream lines(out_);
    for (std::string line; std::getline(lines, line);) documents.push_back(Json::parse(line));
    return documents;
  }

  /// Uploads a simulated route, waits until it is integrated, and returns the map's revision.
  Revision Drive(const std::string& route) {
    const std::vector<std::string> arguments = {
        "simulate", "depot", "--route", route, "--ideal", "--stride", "12"};
    EXPECT_EQ(Run(arguments), 0) << err_;
    const absl::StatusOr<v1::Map> map = client_.GetMap(kDepot);
    EXPECT_TRUE(map.ok()) << map.status();
    return map.ok() ? Revision(map->state().revision()) : Revision();
  }

  std::string Export(v1::ExportFormat format, const VolumeSelection& selection = {}) {
    std::string file;
    const auto header = client_.ExportMap(kDepot, format, selection, [&](std::string_view chunk) {
      file += chunk;
      return absl::OkStatus();
    });
    EXPECT_TRUE(header.ok()) << header.status();
    return file;
  }

  std::unique_ptr<MapMirror> Mirror(const MapFilter& filter = {},
                                    const MirrorCallbacks& callbacks = {}) {
    MirrorOptions options;
    options.filter = filter;
    return MapMirror::Start(ChannelsTo(daemon_.address()), kDepot, options, callbacks);
  }

  void ExpectExport(const MapMirror& mirror, Revision revision) {
    ASSERT_EQ(mirror.AwaitRevision(revision, kMirrorTimeout), absl::OkStatus());
    const std::shared_ptr<const MapSnapshot> map = mirror.snapshot();
    ASSERT_EQ(map->revision, revision);
    EXPECT_TRUE(*WriteVdb(*map, nullptr) == Export(v1::EXPORT_FORMAT_VDB))
        << "the vdb files differ";
    const std::vector<PlacedVolume> volumes = ShownVolumes(*map);
    EXPECT_TRUE(EncodePly(ExtractMapMesh(volumes, map->scale, nullptr)) ==
                Export(v1::EXPORT_FORMAT_PLY))
        << "the ply files differ";
  }

  /// Expects the mirrored objects to be the map's objects selected by `wanted`, each identical to
  /// the daemon's.
  template <typename Wanted>
  void ExpectObjects(const MapMirror& mirror, Wanted wanted) {
    const absl::StatusOr<MapList<v1::Object>> objects = client_.ListObjects(kDepot);
    ASSERT_TRUE(objects.ok()) << objects.status();
    std::vector<ObjectId> ids;
    for (const v1::Object& object : objects->entries) {
      if (wanted(object)) ids.emplace_back(object.id());
    }
    const std::shared_ptr<const MapSnapshot> map = mirror.snapshot();
    std::vector<ObjectId> mirrored;
    std::vector<PlacedVolume> volumes;
    for (const auto& [id, object] : map->objects) {
      mirrored.push_back(id);
      volumes.push_back(VolumeOf(*object));
    }
    ASSERT_EQ(mirrored, ids);
    ASSERT_FALSE(ids.empty()) << "the test would compare nothing";
    EXPECT_TRUE(*WriteVdb(*map, volumes, nullptr) ==
                Export(v1::EXPORT_FORMAT_VDB, {.objects = ids}));
  }

  std::string out_;
  std::string err_;
  TemporaryFolder folder_;
  DaemonProcess daemon_{folder_.path()};
  MapClient client_{OpenChannel(daemon_.address())};
};

TEST_F(MirrorContractTest, FollowsAChangingPlaceBitForBit) {
  std::mutex mutex;
  std::vector<NumberedEvent> events;
  MirrorCallbacks callbacks;
  callbacks.on_events = [&](std::span<const NumberedEvent> more) {
    const std::lock_guard lock(mutex);
    events.insert(events.end(), more.begin(), more.end());
  };
  std::unique_ptr<MapMirror> from_the_start = Mirror({}, callbacks);
  ExpectExport(*from_the_start, Drive("baseline"));
  const Revision revision = Drive("1-5");
  ExpectExport(*from_the_start, revision);
  const std::unique_ptr<MapMirror> from_now = Mirror();
  ExpectExport(*from_now, revision);

  // Every event is reported exactly once. A callback may still run: stopping waits for it.
  const absl::StatusOr<MapList<v1::ObjectEvent>> history = client_.ListEvents(kDepot);
  ASSERT_TRUE(history.ok()) << history.status();
  EXPECT_GT(history->entries.size(), 5U);
  std::vector<NumberedEvent> truth;
  for (const v1::ObjectEvent& event : history->entries) {
    truth.push_back({EventNumber(event.number()), *FromProto(event)});
  }
  from_the_start.reset();
  EXPECT_EQ(events, truth);
}

TEST_F(MirrorContractTest, FiltersShowTheirPartBitForBit) {
  MapFilter of_class;
  of_class.classes = {ClassId(7)};
  MapFilter in_box;
  in_box.boxes_world = {Box(Eigen::Vector3d(0.0, -1.0, -1.0), Eigen::Vector3d(6.0, 6.0, 3.0))};
  MapFilter states_alone;
  states_alone.events = states_alone.volumes = false;
  const std::unique_ptr<MapMirror> classes = Mirror(of_class);
  const std::unique_ptr<MapMirror> box = Mirror(in_box);
  const std::unique_ptr<MapMirror> states = Mirror(states_alone);
  const Revision revision = Drive("clutter");  // Includes the floor.
  for (const auto* mirror : {&classes, &box, &states}) {
    ASSERT_EQ((*mirror)->AwaitRevision(revision, kMirrorTimeout), absl::OkStatus());
  }
  ExpectObjects(*classes, [](const v1::Object& object) { return object.class_id() == 7; });
  EXPECT_EQ(classes->snapshot()->background.leaf_count(), 0U);

  const std::shared_ptr<const MapSnapshot> part = box->snapshot();
  ExpectObjects(*box, [&](const v1::Object& object) {
    return part->objects.contains(ObjectId(object.id()));
  });
  const Box& watched = in_box.boxes_world[0];
  const std::vector<PlacedVolume> background = {BackgroundOf(*part)};
  EXPECT_GT(part->background.leaf_count(), 0U);
  const absl::StatusOr<v1::Map> whole = client_.GetMap(kDepot);
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_LT(part->objects.size(), whole->state().present_objects());
  EXPECT_TRUE(*WriteVdb(*part, background, &watched) ==
              Export(v1::EXPORT_FORMAT_VDB, {.box_world = watched, .objects = {kBackgroundId}}));

  EXPECT_EQ(states->snapshot()->background.leaf_count(), 0U);
  const absl::StatusOr<MapList<v1::Object>> objects = client_.ListObjects(kDepot);
  ASSERT_TRUE(objects.ok());
  EXPECT_EQ(states->Objects().size(), objects->entries.size());
}

TEST_F(MirrorContractTest, GoesOnAfterAKillWithoutAResync) {
  std::mutex mutex;
  std::vector<WatchState> changes;
  MirrorCallbacks callbacks;
  callbacks.on_state = [&](const WatchStateChange& change) {
    const std::lock_guard lock(mutex);
    changes.push_back(change.state);
  };
  const std::unique_ptr<MapMirror> mirror = Mirror({}, callbacks);
  ExpectExport(*mirror, Drive("baseline"));
  daemon_.Kill();
  daemon_.Restart();
  daemon_.AwaitServing();
  ExpectExport(*mirror, Drive("1-5"));
  const std::lock_guard lock(mutex);
  EXPECT_EQ(std::count(changes.begin(), changes.end(), WatchState::kConnected), 2);
  EXPECT_EQ(std::count(changes.begin(), changes.end(), WatchState::kResynced), 0);
}

TEST_F(MirrorContractTest, CommandsFollowTheSameMap) {
  const std::string token = (folder_.path() / "token").string();
  Drive("baseline");
  ASSERT_EQ(Run({"watch",
                 "depot",
                 "--from",
                 "snapshot",
                 "--count",
                 "1",
                 "--json",
                 "--token-file",
                 token}),
            0)
      << err_;
  EXPECT_EQ(Documents().front().at("kind"), "created");
  EXPECT_EQ(Documents().back().at("snapshot"), true);

  const Revision revision = Drive("1-5");
  ASSERT_EQ(Run({"watch",
                 "depot",
                 "--json",
                 "--token-file",
                 token,
                 "--until-revision",
                 std::to_string(revision.value())}),
            0)
      << err_;
  std::set<std::string> kinds;
  for (const Json& document : Documents()) kinds.insert(document.at("kind").get<std::string>());
  for (const char* kind : {"event", "object", "volume", "progress"}) {
    EXPECT_TRUE(kinds.contains(kind)) << kind;
  }

  const std::filesystem::path folder = folder_.path() / "mirrored";
  ASSERT_EQ(Run({"mirror", "depot", "--output", folder.string(), "--once"}), 0) << err_;
  std::ifstream stream(folder / "map.vdb", std::ios::binary);
  const std::string file{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  EXPECT_TRUE(file == Export(v1::EXPORT_FORMAT_VDB));
}

}  // namespace
}  // namespace steadymap

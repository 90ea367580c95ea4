#include "client/map/map_client.h"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "core/volume/tsdf_codec.h"
#include "proto/convert_object.h"
#include "tests/client/map/fake_map_server.h"

namespace steadymap {
namespace {

class MapClientTest : public ::testing::Test {
 protected:
  FakeMapService maps_;
  FakeQueryService queries_;
  FakeServer server_{&maps_, &queries_};
  MapClient client_{server_.channel()};
};

TEST_F(MapClientTest, CreatedMapIsThereUntilItIsDeleted) {
  v1::MapConfig config;
  config.set_voxel_size_m(0.02);
  const absl::StatusOr<v1::Map> created = client_.CreateMap(kKitchen, config);
  ASSERT_TRUE(created.ok()) << created.status();
  EXPECT_EQ(created->name(), "tenants/default/maps/kitchen");
  const absl::StatusOr<v1::Map> read = client_.GetMap(kKitchen);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->config().voxel_size_m(), 0.02);
  EXPECT_TRUE(client_.DeleteMap(kKitchen).ok());
  EXPECT_EQ(client_.GetMap(kKitchen).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(MapClientTest, ErrorsCarryCodeMessageReasonAndField) {
  const absl::Status status = client_.GetMap(kKitchen).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(status.message(), "there is no map tenants/default/maps/kitchen");
  EXPECT_EQ(ReasonOf(status), reason::kNotFound);
  EXPECT_EQ(FieldOf(status), "name");
}

TEST_F(MapClientTest, AMethodThatTheServerLacksIsUnimplemented) {
  FakeMapService maps;
  FakeServer maps_only(&maps);
  const absl::Status status = MapClient(maps_only.channel()).CastRays(kKitchen, {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented);
  EXPECT_EQ(ReasonOf(status), "");
}

TEST_F(MapClientTest, ListsOfSeveralPagesAreWhole) {
  for (const char* map : {"e", "a", "d", "b", "c"}) {
    ASSERT_TRUE(client_.CreateMap({"default", map}, {}).ok());
  }
  ASSERT_TRUE(client_.CreateMap({"other", "x"}, {}).ok());
  const absl::StatusOr<std::vector<v1::Map>> maps = client_.ListMaps("default");
  ASSERT_TRUE(maps.ok()) << maps.status();
  std::string names;
  for (const v1::Map& map : *maps) names += map.name().back();
  EXPECT_EQ(names, "abcde");
}

TEST_F(MapClientTest, PosesOfSeveralPagesAreWhole) {
  for (std::uint64_t sequence = 1; sequence <= 5; ++sequence) {
    queries_.poses.emplace_back().set_map_seq(sequence);
  }
  const absl::StatusOr<std::vector<v1::FramePose>> poses = client_.ListFramePoses(kKitchen);
  ASSERT_TRUE(poses.ok()) << poses.status();
  ASSERT_EQ(poses->size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ((*poses)[i].map_seq(), i + 1);
}

TEST_F(MapClientTest, SamplesOfAnotherNumberThanThePointsAreAnError) {
  queries_.samples.add_samples();
  const std::vector<Eigen::Vector3d> points(2, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(client_.SampleDistance(kKitchen, points).status().code(), absl::StatusCode::kInternal);
  queries_.samples.add_samples()->set_distance_m(0.25);
  const absl::StatusOr<v1::SampleDistanceResponse> answer =
      client_.SampleDistance(kKitchen, points);
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->samples(1).distance_m(), 0.25);
  EXPECT_EQ(queries_.sample_request.points_m(1).z(), 3.0);
}

TEST_F(MapClientTest, RaysAreAskedForAndTheirHitsCome) {
  queries_.hits.set_revision(9);
  v1::RayHit& hit = *queries_.hits.add_hits();
  hit.set_state(v1::POINT_STATE_SURFACE);
  hit.set_range_m(1.5);
  hit.set_object_id(4);
  const std::vector<WorldRay> rays = {{{1.0, 2.0, 3.0}, {0.0, 0.0, -2.0}}};
  const absl::StatusOr<v1::CastRaysResponse> answer = client_.CastRays(kKitchen, rays, 7.5);
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->revision(), 9U);
  EXPECT_EQ(answer->hits(0).range_m(), 1.5);
  EXPECT_EQ(answer->hits(0).object_id(), 4U);
  EXPECT_EQ(queries_.rays_request.map(), kKitchen.ToString());
  EXPECT_EQ(queries_.rays_request.max_range_m(), 7.5);
  ASSERT_EQ(queries_.rays_request.rays_size(), 1);
  EXPECT_EQ(queries_.rays_request.rays(0).origin_m().y(), 2.0);
  EXPECT_EQ(queries_.rays_request.rays(0).direction().z(), -2.0);
  EXPECT_EQ(client_.CastRays(kKitchen, {}).status().code(), absl::StatusCode::kInternal)
      << "different number of hits than rays";
}

TEST_F(MapClientTest, ObjectsOfSeveralPagesAreWholeAndFiltersAreSent) {
  for (std::uint64_t id = 1; id <= 5; ++id) queries_.objects.emplace_back().set_id(id);
  ObjectQuery query;
  query.classes = {ClassId(7)};
  query.box_world = Box(Eigen::Vector3d(-1, -2, -3), Eigen::Vector3d(4, 5, 6));
  query.min_stationarity = 0.5;
  query.changed_since = Revision(3);
  query.with_archived_and_tentative = true;
  const absl::StatusOr<MapList<v1::Object>> objects = client_.ListObjects(kKitchen, query);
  ASSERT_TRUE(objects.ok()) << objects.status();
  EXPECT_EQ(objects->revision, Revision(12));
  ASSERT_EQ(objects->entries.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(objects->entries[i].id(), i + 1);
  const v1::ListObjectsRequest& sent = queries_.objects_request;
  EXPECT_EQ(sent.map(), kKitchen.ToString());
  EXPECT_EQ(sent.class_ids(0), 7U);
  EXPECT_EQ(sent.box().max_m().y(), 5.0);
  EXPECT_EQ(sent.min_stationarity(), 0.5);
  EXPECT_EQ(sent.changed_since(), 3U);
  EXPECT_TRUE(sent.include_archived() && sent.include_tentative());
  EXPECT_EQ(client_.GetObject(kKitchen, ObjectId(4))->id(), 4U);
}

TEST_F(MapClientTest, EventsOfSeveralPagesAreWholeAndFiltersAreSent) {
  for (std::uint64_t number = 1; number <= 5; ++number) {
    queries_.events.emplace_back().set_number(number);
  }
  EventQuery query;
  query.types = {v1::EVENT_TYPE_MOVED};
  query.objects = {ObjectId(8)};
  query.classes = {ClassId(7)};
  query.first = EventNumber(2);
  query.changed_since = Revision(3);
  query.start = Timestamp::FromNanoseconds(1'700'000'000'000'000'001);
  query.end = Timestamp::FromNanoseconds(1'700'000'001'000'000'002);
  const absl::StatusOr<MapList<v1::ObjectEvent>> events = client_.ListEvents(kKitchen, query);
  ASSERT_TRUE(events.ok()) << events.status();
  EXPECT_EQ(events->revision, Revision(12));
  ASSERT_EQ(events->entries.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(events->entries[i].number(), i + 1);
  const v1::ListEventsRequest& sent = queries_.events_request;
  EXPECT_EQ(sent.types(0), v1::EVENT_TYPE_MOVED);
  EXPECT_EQ(sent.object_ids(0), 8U);
  EXPECT_EQ(sent.class_ids(0), 7U);
  EXPECT_EQ(sent.first_number(), 2U);
  EXPECT_EQ(sent.changed_since(), 3U);
  EXPECT_EQ(sent.start_time().seconds(), 1'700'000'000);
  EXPECT_EQ(sent.start_time().nanos(), 1);
  EXPECT_EQ(sent.end_time().seconds(), 1'700'000'001);
  EXPECT_EQ(sent.end_time().nanos(), 2);
  ASSERT_TRUE(client_.ListEvents(kKitchen).ok());
  EXPECT_FALSE(sent.has_start_time() || sent.has_end_time());
}

LeafVoxels RandomLeaf(std::mt19937* random) {
  std::uniform_int_distribution<int> steps(-kMaxDistanceSteps, kMaxDistanceSteps);
  std::uniform_int_distribution<int> weights(1, 2000);
  LeafVoxels voxels;
  for (std::size_t offset = 0; offset < kLeafVoxels; offset += 3) {
    voxels.observed[offset >> 6] |= std::uint64_t{1} << (offset & 63);
    const int distance_steps = steps(*random);
    voxels.voxels[offset] = Voxel(distance_steps, weights(*random));
  }
  return voxels;
}

TEST_F(MapClientTest, ASectionHasTheServersVoxels) {
  const VoxelScale scale{0.04, 0.12};
  std::mt19937 random(4);
  std::map<LeafOrigin, LeafVoxels> truth;
  queries_.section.assign(1, {});
  v1::GetMapSectionResponse::Header& header = *queries_.section[0].mutable_header();
  header.set_revision(12);
  header.set_voxel_size_m(scale.voxel_size_m);
  header.set_truncation_m(scale.truncation_m);
  for (std::int32_t i = -3; i < 4; ++i) {
    const LeafOrigin origin{8 * i, 80 * i, 8};
    truth[origin] = RandomLeaf(&random);
    TsdfGrid grid;
    grid.StoreLeaf(origin, truth[origin]);
    v1::PackedLeaf& leaf = *queries_.section.emplace_back().mutable_leaves()->add_leaves();
    leaf.set_origin_x(origin.x);
    leaf.set_origin_y(origin.y);
    leaf.set_origin_z(origin.z);
    leaf.set_packed(PackLeaf(grid.FindLeaf(origin)));
  }
  const Box box(Eigen::Vector3d(-1, -2, -3), Eigen::Vector3d(4, 5, 6));
  const absl::StatusOr<MapSnapshot> section = client_.GetMapSection(kKitchen, {.box_world = box});
  ASSERT_TRUE(section.ok()) << section.status();
  EXPECT_EQ(section->revision, Revision(12));
  EXPECT_EQ(section->scale, scale);
  EXPECT_EQ(section->background.leaf_count(), truth.size());
  for (const auto& [origin, voxels] : truth) {
    const LeafView leaf = section->background.FindLeaf(origin);
    ASSERT_TRUE(leaf);
    EXPECT_EQ(leaf.observed, voxels.observed);
    EXPECT_TRUE(std::equal(leaf.voxels, leaf.voxels + kLeafVoxels, voxels.voxels.begin()));
  }
  EXPECT_EQ(queries_.section_request.box().max_m().y(), 5.0);
}

TEST_F(MapClientTest, ASectionHasItsObjectsWithTheirVoxels) {
  const VoxelScale scale;
  std::mt19937 random(5);
  const LeafVoxels voxels = RandomLeaf(&random);
  TsdfGrid grid;
  grid.StoreLeaf({8, 0, -16}, voxels);
  MapObject object;
  object.id = ObjectId(3);
  object.status = ObjectStatus::kArchived;
  object.T_world_object = {{1.0, 2.0, 3.0}, 0.5};
  queries_.section.assign(3, {});
  queries_.section[0].mutable_header()->set_voxel_size_m(scale.voxel_size_m);
  queries_.section[0].mutable_header()->set_truncation_m(scale.truncation_m);
  *queries_.section[1].mutable_objects()->add_objects() = ToProto(object);
  v1::PackedLeaf& leaf = *queries_.section[2].mutable_leaves()->add_leaves();
  leaf.set_object_id(3);
  leaf.set_origin_x(8);
  leaf.set_origin_z(-16);
  leaf.set_packed(PackLeaf(grid.FindLeaf({8, 0, -16})));
  const absl::StatusOr<MapSnapshot> section =
      client_.GetMapSection(kKitchen, {.objects = {ObjectId(3)}});
  ASSERT_TRUE(section.ok()) << section.status();
  EXPECT_EQ(queries_.section_request.object_ids(0), 3U);
  EXPECT_EQ(section->background.leaf_count(), 0U);
  ASSERT_EQ(section->objects.size(), 1U);
  const MapObject& read = *section->objects.at(ObjectId(3));
  EXPECT_EQ(static_cast<const ObjectState&>(read), static_cast<const ObjectState&>(object));
  LeafVoxels stored;
  read.volume->LoadLeaf({8, 0, -16}, &stored);
  EXPECT_EQ(stored, voxels);

  queries_.section[1].mutable_objects()->mutable_objects(0)->mutable_belief()->set_alpha(-1.0);
  EXPECT_EQ(client_.GetMapSection(kKitchen).status().code(), absl::StatusCode::kInvalidArgument);
  queries_.section.erase(queries_.section.begin() + 1);
  EXPECT_EQ(client_.GetMapSection(kKitchen).status().code(), absl::StatusCode::kInternal)
      << "a leaf of an object that was not sent";
}

TEST_F(MapClientTest, DamagedSectionsAreErrors) {
  queries_.section.assign(1, {});
  queries_.section[0].mutable_leaves()->add_leaves();
  EXPECT_EQ(client_.GetMapSection(kKitchen).status().code(), absl::StatusCode::kInternal)
      << "leaves before the header";

  queries_.section.assign(2, {});
  queries_.section[0].mutable_header()->set_revision(1);
  EXPECT_EQ(client_.GetMapSection(kKitchen).status().code(), absl::StatusCode::kInternal)
      << "invalid voxel size";

  queries_.section[0].mutable_header()->set_voxel_size_m(0.05);
  queries_.section[0].mutable_header()->set_truncation_m(0.15);
  v1::PackedLeaf& leaf = *queries_.section[1].mutable_leaves()->add_leaves();
  leaf.set_packed("garbage");
  EXPECT_EQ(client_.GetMapSection(kKitchen).status().code(), absl::StatusCode::kDataLoss);

  leaf.set_origin_x(3);
  EXPECT_EQ(client_.GetMapSection(kKitchen).status().code(), absl::StatusCode::kInternal)
      << "an origin between leaves";
}

TEST_F(MapClientTest, ExportsArriveChunkByChunk) {
  queries_.SetFile({"abc", "", "de"}, "abcde");
  std::string file;
  const auto summary =
      client_.ExportMap(kKitchen, v1::EXPORT_FORMAT_GLB, {}, [&](std::string_view chunk) {
        file += chunk;
        return absl::OkStatus();
      });
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->revision, Revision(7));
  EXPECT_EQ(summary->file_bytes, 5U);
  EXPECT_EQ(summary->triangles, 12U);
  EXPECT_EQ(file, "abcde");
  EXPECT_EQ(queries_.export_request.format(), v1::EXPORT_FORMAT_GLB);
  EXPECT_FALSE(queries_.export_request.has_box());
}

TEST_F(MapClientTest, AnExportThatIsNotWholeIsAnError) {
  const auto status = [this] {
    return client_
        .ExportMap(
            kKitchen, v1::EXPORT_FORMAT_PLY, {}, [](std::string_view) { return absl::OkStatus(); })
        .status();
  };
  queries_.SetFile({"abc"}, "abcde");
  EXPECT_EQ(status().code(), absl::StatusCode::kDataLoss) << "a chunk is missing";
  EXPECT_EQ(ReasonOf(status()), "CHECKSUM");
  queries_.SetFile({"abc", "xe"}, "abcde");
  EXPECT_EQ(status().code(), absl::StatusCode::kDataLoss) << "as long, but another";
  queries_.SetFile({"abc", "de"}, "abcde");
  queries_.file.pop_back();
  EXPECT_EQ(status().code(), absl::StatusCode::kDataLoss) << "no trailer";
  EXPECT_EQ(ReasonOf(status()), "CHECKSUM");
  queries_.file.clear();
  EXPECT_EQ(status().code(), absl::StatusCode::kDataLoss) << "nothing at all";
  queries_.export_status = grpc::Status(grpc::StatusCode::UNAVAILABLE, "going down");
  EXPECT_EQ(status().code(), absl::StatusCode::kUnavailable) << "its own reason goes first";
}

TEST_F(MapClientTest, AnExportWithoutOrderBreaksTheProtocol) {
  const auto code = [this] {
    return client_
        .ExportMap(
            kKitchen, v1::EXPORT_FORMAT_PLY, {}, [](std::string_view) { return absl::OkStatus(); })
        .status()
        .code();
  };
  queries_.SetFile({"abc"}, "abc");
  queries_.file.erase(queries_.file.begin());
  EXPECT_EQ(code(), absl::StatusCode::kInternal) << "no header";
  queries_.SetFile({"abc"}, "abc");
  queries_.file.insert(queries_.file.begin(), queries_.file.front());
  EXPECT_EQ(code(), absl::StatusCode::kInternal) << "two headers";
  queries_.SetFile({"abc"}, "abc");
  queries_.file.push_back(queries_.file[1]);
  EXPECT_EQ(code(), absl::StatusCode::kInternal) << "a chunk behind the trailer";
}

TEST_F(MapClientTest, AnErrorOfTheSinkEndsTheExport) {
  queries_.SetFile({"abc", "de"}, "abcde");
  absl::Status full = absl::FailedPreconditionError("the disk is full");
  int chunks = 0;
  const auto header = client_.ExportMap(kKitchen, v1::EXPORT_FORMAT_PLY, {}, [&](std::string_view) {
    ++chunks;
    return full;
  });
  EXPECT_EQ(header.status(), full);
  EXPECT_EQ(chunks, 1);
}

}  // namespace
}  // namespace steadymap

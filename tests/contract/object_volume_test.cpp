// Tests the service responses about the volumes of a map with objects.

#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/map/map_counts.h"
#include "core/volume/tsdf_codec.h"
#include "proto/convert_geometry.h"
#include "tests/contract/object_map.h"
#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"

namespace steadymap {
namespace {

using absl::StatusCode;

class ObjectVolumeTest : public ::testing::TestWithParam<Transport> {
 protected:
  ObjectVolumeTest() { StoreObjectMap(&service_); }

  absl::Status Section(const v1::GetMapSectionRequest& request,
                       std::vector<v1::GetMapSectionResponse>* messages) {
    grpc::ClientContext context;
    SetDeadline(&context);
    const auto reader = service_.queries().GetMapSection(&context, request);
    v1::GetMapSectionResponse message;
    while (reader->Read(&message)) messages->push_back(message);
    return FromGrpcStatus(reader->Finish());
  }

  const MapSnapshot truth_ = MakeObjectMap();
  TestService service_{GetParam()};
  const std::string map_ = service_.CreateMap("hall");
};

INSTANTIATE_TEST_SUITE_P(Transports,
                         ObjectVolumeTest,
                         ::testing::Values(Transport::kInProcess, Transport::kLoopback),
                         TransportName);

TEST_P(ObjectVolumeTest, PointsAndRaysSeeBackgroundAndPresentObjects) {
  const Eigen::Isometry3d T_world_box = truth_.objects.at(ObjectId(3))->T_world_object.ToIsometry();
  v1::SampleDistanceRequest points;
  points.set_map(map_);
  *points.add_points_m() = ToProto(Eigen::Vector3d(T_world_box * Eigen::Vector3d(0.25, 0, 0)));
  *points.add_points_m() = ToProto(Eigen::Vector3d(0.0, 0.0, 0.05));
  // The former position of the archived box.
  *points.add_points_m() = ToProto(Eigen::Vector3d(0.5, 0.5, 0.95));
  v1::SampleDistanceResponse samples;
  ASSERT_TRUE(Call([&](auto* context) {
                return service_.queries().SampleDistance(context, points, &samples);
              }).ok());
  EXPECT_NEAR(samples.samples(0).distance_m(), 0.05, 1e-3);
  EXPECT_EQ(samples.samples(0).object_id(), 3U);
  EXPECT_EQ(samples.samples(0).class_id(), 103U);
  EXPECT_NEAR(samples.samples(1).distance_m(), 0.05, 1e-3);
  EXPECT_EQ(samples.samples(1).object_id(), 0U);
  EXPECT_EQ(samples.samples(0).state(), v1::POINT_STATE_FREE);
  EXPECT_EQ(samples.samples(2).state(), v1::POINT_STATE_UNKNOWN);
  EXPECT_FALSE(samples.samples(2).has_distance_m());

  v1::CastRaysRequest rays;
  rays.set_map(map_);
  for (const double x : {-0.5, 0.5}) {
    v1::Ray* ray = rays.add_rays();
    *ray->mutable_origin_m() = ToProto(Eigen::Vector3d(x, 0.5, 3.0));
    *ray->mutable_direction() = ToProto(Eigen::Vector3d(0.0, 0.0, -1.0));
  }
  v1::CastRaysResponse hits;
  ASSERT_TRUE(
      Call([&](auto* context) { return service_.queries().CastRays(context, rays, &hits); }).ok());
  EXPECT_EQ(hits.hits(0).object_id(), 1U);
  EXPECT_EQ(hits.hits(0).class_id(), 101U);
  EXPECT_NEAR(hits.hits(0).point_m().z(), 0.95, 1e-3);
  EXPECT_EQ(hits.hits(1).state(), v1::POINT_STATE_SURFACE);
  EXPECT_EQ(hits.hits(1).object_id(), 0U) << "an archived box stops no ray";
}

TEST_P(ObjectVolumeTest, SectionsHoldObjectsWithTheirLeaves) {
  v1::GetMapSectionRequest request;
  request.set_map(map_);
  std::vector<v1::GetMapSectionResponse> messages;
  ASSERT_TRUE(Section(request, &messages).ok());
  ASSERT_GE(messages.size(), 3U);
  ASSERT_EQ(messages[1].objects().objects_size(), 2);
  EXPECT_EQ(messages[1].objects().objects(0).id(), 1U);
  EXPECT_EQ(messages[1].objects().objects(1).id(), 3U);
  std::map<std::uint64_t, std::size_t> leaves;
  for (std::size_t i = 2; i < messages.size(); ++i) {
    for (const v1::PackedLeaf& leaf : messages[i].leaves().leaves()) {
      const LeafKey key{ObjectId(leaf.object_id()),
                        {leaf.origin_x(), leaf.origin_y(), leaf.origin_z()}};
      ASSERT_EQ(leaf.packed(), PackLeaf(FindLeaf(truth_, key)));
      ++leaves[leaf.object_id()];
    }
  }
  EXPECT_EQ(leaves.size(), 3U);
  EXPECT_EQ(leaves[0], truth_.background.leaf_count());
  EXPECT_EQ(leaves[3], truth_.objects.at(ObjectId(3))->volume->leaf_count());
  EXPECT_EQ(leaves[0] + leaves[1] + leaves[3], service_.GetMap(map_)->state().leaves());

  // A box around the upper half of object 3 without the floor and other objects.
  *request.mutable_box() =
      ToProto(Eigen::AlignedBox3d(Eigen::Vector3d(1.0, 0.0, 0.8), Eigen::Vector3d(2.0, 1.0, 1.2)));
  messages.clear();
  ASSERT_TRUE(Section(request, &messages).ok());
  ASSERT_EQ(messages.size(), 3U);
  ASSERT_EQ(messages[1].objects().objects_size(), 1);
  EXPECT_EQ(messages[1].objects().objects(0).id(), 3U);
  for (const v1::PackedLeaf& leaf : messages[2].leaves().leaves()) EXPECT_EQ(leaf.object_id(), 3U);

  request.clear_box();
  request.add_object_ids(2);
  messages.clear();
  ASSERT_TRUE(Section(request, &messages).ok());
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_EQ(messages[1].objects().objects(0).standing(), v1::OBJECT_STANDING_ARCHIVED);
  request.add_object_ids(9);
  EXPECT_THAT(Section(request, &messages),
              IsError(StatusCode::kNotFound, "NOT_FOUND", "object_ids[1]"));
}

TEST_P(ObjectVolumeTest, ExportsHoldTheChosenVolumes) {
  const auto size = [&](v1::ExportFormat format, const std::vector<std::uint64_t>& ids) {
    v1::ExportMapRequest request;
    request.set_map(map_);
    request.set_format(format);
    for (const std::uint64_t id : ids) request.add_object_ids(id);
    return service_.Export(request)->size();
  };
  for (const v1::ExportFormat format :
       {v1::EXPORT_FORMAT_PLY, v1::EXPORT_FORMAT_GLB, v1::EXPORT_FORMAT_VDB}) {
    EXPECT_EQ(size(format, {}), size(format, {3, 1, 0, 1})) << "background and present objects";
    EXPECT_LT(size(format, {0}), size(format, {0, 1}));
    EXPECT_LT(size(format, {2}), size(format, {2, 3}));
    EXPECT_GT(size(format, {2}), 1000U) << "archived objects too";
  }
}

TEST_P(ObjectVolumeTest, CountsIncludeObjects) {
  const MapCounts truth = CountMap(truth_);
  const absl::StatusOr<v1::Map> map = service_.GetMap(map_);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->state().present_objects(), 2U);
  EXPECT_EQ(map->state().archived_objects(), 1U);
  EXPECT_EQ(map->state().leaves(), truth.leaves);
  EXPECT_EQ(map->state().voxels(), truth.voxels);
  EXPECT_GT(map->state().memory_bytes(), truth_.background.memory_bytes());
}

TEST_P(ObjectVolumeTest, ObjectsCountAgainstTheByteBudget) {
  v1::UpdateMapRequest request;
  request.mutable_map()->set_name(map_);
  request.mutable_update_mask()->add_paths("byte_budget");
  const auto upload_with_budget = [&](std::uint64_t byte_budget, std::uint64_t client_seq) {
    request.mutable_map()->set_byte_budget(byte_budget);
    v1::Map map;
    const absl::Status status =
        Call([&](auto* context) { return service_.maps().UpdateMap(context, request, &map); });
    EXPECT_TRUE(status.ok()) << status;
    return UploadByCall(&service_, {map_}, MakeBatch(client_seq, 1), v1::ACK_LEVEL_DURABLE)
        .status();
  };
  const std::uint64_t all_bytes = service_.GetMap(map_)->state().memory_bytes();
  EXPECT_EQ(ReasonOf(upload_with_budget(truth_.background.memory_bytes(), 1)), "MAP_BYTES");
  EXPECT_EQ(ReasonOf(upload_with_budget(all_bytes - 1, 1)), "MAP_BYTES");
  EXPECT_TRUE(upload_with_budget(all_bytes, 1).ok());
}

}  // namespace
}  // namespace steadymap

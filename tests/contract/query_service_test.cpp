#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/crc32c.h"
#include "core/volume/tsdf_codec.h"
#include "proto/convert_geometry.h"
#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kNan;

using absl::StatusCode;

/// A map of a wall at x = 2 m, observed eight times.
class QueryServiceTest : public ::testing::TestWithParam<Transport> {
 protected:
  QueryServiceTest() {
    const absl::Status status = UploadAndClose(&service_, {map_}, MakeBatch(1, 8));
    EXPECT_TRUE(status.ok()) << status;
  }

  absl::Status Sample(const std::vector<Eigen::Vector3d>& points,
                      v1::SampleDistanceResponse* response) {
    v1::SampleDistanceRequest request;
    request.set_map(map_);
    for (const Eigen::Vector3d& point : points) *request.add_points_m() = ToProto(point);
    return Call([&](auto* context) {
      return service_.queries().SampleDistance(context, request, response);
    });
  }

  absl::Status Cast(const v1::CastRaysRequest& request, v1::CastRaysResponse* response) {
    return Call(
        [&](auto* context) { return service_.queries().CastRays(context, request, response); });
  }

  absl::Status Section(const v1::GetMapSectionRequest& request,
                       std::vector<v1::GetMapSectionResponse>* messages) {
    grpc::ClientContext context;
    SetDeadline(&context);
    const auto reader = service_.queries().GetMapSection(&context, request);
    v1::GetMapSectionResponse message;
    while (reader->Read(&message)) messages->push_back(message);
    return FromGrpcStatus(reader->Finish());
  }

  TestService service_{GetParam()};
  const std::string map_ = service_.CreateMap("hall");
};

INSTANTIATE_TEST_SUITE_P(Transports,
                         QueryServiceTest,
                         ::testing::Values(Transport::kInProcess, Transport::kLoopback),
                         TransportName);

TEST_P(QueryServiceTest, DistanceOfPointsBeforeAndBehindTheWall) {
  v1::SampleDistanceResponse response;
  ASSERT_TRUE(Sample({{1.95, 0, 0}, {2.03, 0.1, 0.1}, {0.5, 0, 0}, {-3, 0, 0}}, &response).ok());
  EXPECT_EQ(response.revision(), 8U);
  ASSERT_EQ(response.samples_size(), 4);
  EXPECT_EQ(response.samples(0).state(), v1::POINT_STATE_FREE);
  EXPECT_NEAR(response.samples(0).distance_m(), 0.05, 0.005);
  EXPECT_NEAR(response.samples(0).gradient().x(), -1.0, 0.01);
  EXPECT_EQ(response.samples(1).state(), v1::POINT_STATE_SURFACE);
  EXPECT_NEAR(response.samples(1).distance_m(), -0.03, 0.005);
  for (const int far : {2, 3}) {
    EXPECT_EQ(response.samples(far).state(), v1::POINT_STATE_UNKNOWN);
    EXPECT_FALSE(response.samples(far).has_distance_m());
  }
}

TEST_P(QueryServiceTest, RaysMeetTheWallFromTheFrontOnly) {
  v1::CastRaysRequest request;
  request.set_map(map_);
  for (const double direction : {1e-3, -1.0}) {
    v1::Ray* ray = request.add_rays();
    *ray->mutable_origin_m() = ToProto(Eigen::Vector3d(0.5, 0.05, 0.0));
    *ray->mutable_direction() = ToProto(Eigen::Vector3d(direction, 0, 0));
  }
  v1::CastRaysResponse response;
  ASSERT_TRUE(Cast(request, &response).ok());
  EXPECT_EQ(response.revision(), 8U);
  ASSERT_EQ(response.hits_size(), 2);
  EXPECT_EQ(response.hits(0).state(), v1::POINT_STATE_SURFACE);
  EXPECT_NEAR(response.hits(0).range_m(), 1.5, 0.005);
  EXPECT_NEAR(response.hits(0).normal().x(), -1.0, 0.01);
  EXPECT_EQ(response.hits(1).state(), v1::POINT_STATE_UNKNOWN);
  request.set_max_range_m(1.0);
  response.Clear();
  ASSERT_TRUE(Cast(request, &response).ok());
  EXPECT_EQ(response.hits(0).state(), v1::POINT_STATE_UNKNOWN);
}

TEST_P(QueryServiceTest, WrongPointsAndRaysAreNamed) {
  v1::SampleDistanceResponse samples;
  EXPECT_THAT(Sample({{0, 0, 0}, {0, kNan, 0}}, &samples),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "points_m[1]"));
  EXPECT_THAT(Sample(std::vector<Eigen::Vector3d>(100'001, Eigen::Vector3d::Zero()), &samples),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "points_m"));
  v1::CastRaysRequest request;
  request.set_map(map_);
  v1::Ray* ray = request.add_rays();
  v1::CastRaysResponse hits;
  EXPECT_THAT(Cast(request, &hits),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "rays[0].direction"));
  ray->mutable_direction()->set_x(1.0);
  ray->mutable_origin_m()->set_z(std::numeric_limits<double>::infinity());
  EXPECT_THAT(Cast(request, &hits),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "rays[0].origin_m"));
  ray->clear_origin_m();
  request.set_max_range_m(kNan);
  EXPECT_THAT(Cast(request, &hits),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "max_range_m"));
}

TEST_P(QueryServiceTest, ReadsOfThePastAreNotPossibleYet) {
  const auto check = [&](auto request, auto response, auto call) {
    request.set_map(map_);
    request.mutable_as_of()->set_revision(3);
    EXPECT_THAT(Call([&](auto* context) {
                  return (service_.queries().*call)(context, request, &response);
                }),
                IsError(StatusCode::kUnimplemented, "AS_OF", "as_of"))
        << request.GetTypeName();
    request.mutable_as_of()->mutable_capture_time()->set_seconds(100);
    EXPECT_THAT(Call([&](auto* context) {
                  return (service_.queries().*call)(context, request, &response);
                }),
                IsError(StatusCode::kUnimplemented, "AS_OF", "as_of"));
  };
  using Stub = v1::QueryService::StubInterface;
  check(v1::GetObjectRequest(), v1::GetObjectResponse(), &Stub::GetObject);
  check(v1::ListObjectsRequest(), v1::ListObjectsResponse(), &Stub::ListObjects);
  check(v1::ListEventsRequest(), v1::ListEventsResponse(), &Stub::ListEvents);
  check(v1::SampleDistanceRequest(), v1::SampleDistanceResponse(), &Stub::SampleDistance);
  check(v1::CastRaysRequest(), v1::CastRaysResponse(), &Stub::CastRays);
  check(v1::ListFramePosesRequest(), v1::ListFramePosesResponse(), &Stub::ListFramePoses);
  check(v1::ListRobotsRequest(), v1::ListRobotsResponse(), &Stub::ListRobots);
  v1::GetMapSectionRequest section;
  section.set_map(map_);
  section.mutable_as_of()->set_revision(3);
  std::vector<v1::GetMapSectionResponse> messages;
  EXPECT_THAT(Section(section, &messages), IsError(StatusCode::kUnimplemented, "AS_OF", "as_of"));
  v1::ExportMapRequest request;
  request.set_map(map_);
  request.set_format(v1::EXPORT_FORMAT_PLY);
  request.mutable_as_of()->set_revision(3);
  grpc::ClientContext context;
  SetDeadline(&context);
  EXPECT_THAT(FromGrpcStatus(service_.queries().ExportMap(&context, request)->Finish()),
              IsError(StatusCode::kUnimplemented, "AS_OF", "as_of"));
}

TEST_P(QueryServiceTest, SectionHoldsTheLeavesThatTouchTheBox) {
  v1::GetMapSectionRequest request;
  request.set_map(map_);
  std::vector<v1::GetMapSectionResponse> all;
  ASSERT_TRUE(Section(request, &all).ok());
  ASSERT_GE(all.size(), 2U);
  EXPECT_EQ(all[0].header().revision(), 8U);
  EXPECT_DOUBLE_EQ(all[0].header().voxel_size_m(), 0.05);
  std::uint64_t leaves = 0;
  LeafVoxels voxels;
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_LE(all[i].ByteSizeLong(), std::size_t{1} << 20);
    for (const v1::PackedLeaf& leaf : all[i].leaves().leaves()) {
      EXPECT_TRUE(UnpackLeaf(leaf.packed(), &voxels).ok());
      ++leaves;
    }
  }
  EXPECT_EQ(leaves, service_.GetMap(map_)->state().leaves());

  *request.mutable_box() = ToProto(Box(Eigen::Vector3d(2, 0, 0), Eigen::Vector3d(2, 0, 0)));
  std::vector<v1::GetMapSectionResponse> one;
  ASSERT_TRUE(Section(request, &one).ok());
  ASSERT_EQ(one.size(), 2U);
  EXPECT_EQ(one[1].leaves().leaves_size(), 1);
  EXPECT_EQ(one[1].leaves().leaves(0).origin_x(), 40);
}

TEST_P(QueryServiceTest, WrongSectionsAndExportsAreNamed) {
  v1::GetMapSectionRequest request;
  request.set_map(map_);
  request.add_object_ids(0);
  request.add_object_ids(7);
  std::vector<v1::GetMapSectionResponse> messages;
  EXPECT_THAT(Section(request, &messages),
              IsError(StatusCode::kNotFound, "NOT_FOUND", "object_ids[1]"));
  request.clear_object_ids();
  request.mutable_box()->mutable_min_m();
  EXPECT_THAT(Section(request, &messages),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "box.max_m"));
  request.set_map("tenants/test/maps/none");
  EXPECT_THAT(Section(request, &messages), IsError(StatusCode::kNotFound, "NOT_FOUND", "map"));
  EXPECT_THAT(service_.Export(map_, v1::EXPORT_FORMAT_UNSPECIFIED).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "format"));
}

TEST_P(QueryServiceTest, ExportsAreFilesOfTheirFormats) {
  EXPECT_TRUE(service_.Export(map_, v1::EXPORT_FORMAT_PLY)->starts_with("ply\n"));
  EXPECT_TRUE(service_.Export(map_, v1::EXPORT_FORMAT_GLB)->starts_with("glTF"));
  EXPECT_TRUE(service_.Export(map_, v1::EXPORT_FORMAT_VDB)->starts_with(" BDV"));
}

TEST_P(QueryServiceTest, ExportsSayWhatTheyHoldFirstAndWhatWasSentLast) {
  for (const v1::ExportFormat format :
       {v1::EXPORT_FORMAT_PLY, v1::EXPORT_FORMAT_GLB, v1::EXPORT_FORMAT_VDB}) {
    v1::ExportMapRequest request;
    request.set_map(map_);
    request.set_format(format);
    grpc::ClientContext context;
    SetDeadline(&context);
    const auto reader = service_.queries().ExportMap(&context, request);
    std::vector<v1::ExportMapResponse> messages;
    for (v1::ExportMapResponse message; reader->Read(&message);) messages.push_back(message);
    EXPECT_TRUE(reader->Finish().ok());
    ASSERT_GE(messages.size(), 3U);
    EXPECT_EQ(messages.front().header().revision(), 8U);
    EXPECT_EQ(messages.front().header().triangles() > 100, format != v1::EXPORT_FORMAT_VDB);
    std::string file;
    for (std::size_t i = 1; i + 1 < messages.size(); ++i) {
      EXPECT_FALSE(messages[i].chunk().empty());
      EXPECT_LE(messages[i].chunk().size(), std::size_t{1} << 20);
      file += messages[i].chunk();
    }
    EXPECT_EQ(messages.back().trailer().file_bytes(), file.size());
    EXPECT_EQ(messages.back().trailer().crc32c(), ExtendCrc32c(0, file));
  }
}

TEST_P(QueryServiceTest, ExportThatIsCancelledHarmsNobody) {
  v1::ExportMapRequest request;
  request.set_map(map_);
  request.set_format(v1::EXPORT_FORMAT_PLY);
  for (int i = 0; i < 32; ++i) {
    grpc::ClientContext context;
    const auto reader = service_.queries().ExportMap(&context, request);
    context.TryCancel();
    EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  EXPECT_TRUE(service_.GetMap(map_).ok());
}

TEST_P(QueryServiceTest, PosesComeInPagesInTheOrderOfTheLog) {
  v1::ListFramePosesRequest request;
  request.set_map(map_);
  request.set_page_size(3);
  v1::ListFramePosesResponse response;
  const auto list = [&](auto* context) {
    return service_.queries().ListFramePoses(context, request, &response);
  };
  std::vector<v1::FramePose> poses;
  do {
    response.Clear();
    ASSERT_TRUE(Call(list).ok());
    EXPECT_EQ(response.revision(), 8U);
    poses.insert(poses.end(), response.poses().begin(), response.poses().end());
    request.set_page_token(response.next_page_token());
  } while (!response.next_page_token().empty());
  ASSERT_EQ(poses.size(), 8U);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].map_seq(), i + 1);
    EXPECT_EQ(poses[i].robot(), "robot-1");
    EXPECT_NEAR(
        poses[i].world_from_camera().position_m().y(), 0.01 * static_cast<double>(i + 1), 1e-12);
    EXPECT_EQ(poses[i].capture_time().seconds(), 101 + static_cast<int>(i));
  }
  request.set_page_token("AAAA");
  EXPECT_THAT(Call(list), IsError(StatusCode::kInvalidArgument, "BAD_PAGE_TOKEN", "page_token"));
}

TEST_P(QueryServiceTest, RobotsAreListedWhereTheMapKnowsThem) {
  v1::ListRobotsRequest request;
  v1::ListRobotsResponse response;
  const auto list = [&](auto* context) {
    return service_.queries().ListRobots(context, request, &response);
  };
  request.set_map(map_);
  ASSERT_TRUE(Call(list).ok());
  EXPECT_EQ(response.revision(), 8U);
  EXPECT_EQ(response.robots_size(), 0) << "a map of the static policy knows none";

  const std::string depot = service_.CreatePocdMap("depot");
  const absl::Status status = UploadAndClose(&service_, {depot}, MakeBatch(1, 8));
  ASSERT_TRUE(status.ok()) << status;
  request.set_map(depot);
  ASSERT_TRUE(Call(list).ok());
  ASSERT_EQ(response.robots_size(), 1);
  const v1::Robot& robot = response.robots(0);
  EXPECT_EQ(robot.robot(), "robot-1");
  EXPECT_EQ(robot.sensor(), "camera");
  EXPECT_EQ(robot.trust(), v1::ROBOT_TRUST_TRUSTED);
  EXPECT_EQ(robot.last_capture_time().seconds(), 108);
  EXPECT_NEAR(robot.world_from_camera().position_m().y(), 0.08, 1e-12);
  request.set_map("tenants/test/maps/nowhere");
  EXPECT_THAT(Call(list), IsError(StatusCode::kNotFound, "NOT_FOUND", "map"));
}

TEST_P(QueryServiceTest, RestartShowsTheSameMapBitForBit) {
  const std::string before = *service_.Export(map_, v1::EXPORT_FORMAT_VDB);
  service_.Restart();
  EXPECT_EQ(*service_.Export(map_, v1::EXPORT_FORMAT_VDB), before);
}

}  // namespace
}  // namespace steadymap

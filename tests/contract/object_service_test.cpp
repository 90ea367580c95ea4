// What the services say of a map with objects: a floor, boxes over it, and a short history, put
// into the store as a mapper would have.

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/map_counts.h"
#include "core/map_delta.h"
#include "core/tsdf_codec.h"
#include "proto/convert_event.h"
#include "proto/convert_geometry.h"
#include "proto/convert_object.h"
#include "tests/contract/test_service.h"
#include "tests/support/analytic_map.h"

namespace steadymap {
namespace {

using absl::StatusCode;
using testing::AddObject;
using testing::BoxObject;
using testing::FloorMap;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t kRevision = 7;
const Eigen::Vector3d kSizeM(0.4, 0.3, 0.3);

/// Box `id` over the floor at x = id - 1.5 m, of class 100 + id, changed by frame `id`.
MapObject MakeBox(std::uint64_t id, ObjectStanding standing, double alpha) {
  MapObject object =
      BoxObject(ObjectId(id), kSizeM, {{-1.5 + static_cast<double>(id), 0.5, 0.8}, 0.3});
  object.standing = standing;
  object.revision = Revision(id);
  object.belief.alpha = alpha;
  object.votes = {{ClassId(4), 1.0}, {object.class_id, 3.0}};
  object.first_seen = Timestamp::FromSeconds(100.0);
  object.last_seen = Timestamp::FromSeconds(200.0);
  object.views = 5;
  return object;
}

MapSnapshot MakeMap() {
  MapSnapshot map = FloorMap();
  map.revision = Revision(kRevision);
  map.last_capture_time = Timestamp::FromSeconds(200.0);
  AddObject(MakeBox(1, ObjectStanding::kPresent, 9.0), &map);
  AddObject(MakeBox(2, ObjectStanding::kArchived, 0.5), &map);
  AddObject(MakeBox(3, ObjectStanding::kPresent, 3.0), &map);
  AddObject(MakeBox(4, ObjectStanding::kTentative, 2.0), &map);
  map.newest_object = ObjectId(4);
  return map;
}

std::vector<ObjectEvent> MakeHistory(const MapSnapshot& map) {
  std::vector<ObjectEvent> events;
  const auto add = [&](EventType type, EventReason why, std::uint64_t id, std::uint64_t revision) {
    ObjectEvent& event = events.emplace_back();
    event.type = type;
    event.reason = why;
    event.object = ObjectId(id);
    event.class_id = map.objects.at(event.object)->class_id;
    event.time = Timestamp::FromSeconds(100.0 + 10.0 * static_cast<double>(revision));
    event.revision = Revision(revision);
    event.center_world = map.objects.at(event.object)->cuboid.center_world;
  };
  add(EventType::kCreated, EventReason::kNewSurface, 1, 2);
  add(EventType::kCreated, EventReason::kNewSurface, 2, 2);
  add(EventType::kCreated, EventReason::kNewSurface, 3, 4);
  add(EventType::kMoved, EventReason::kShapeMatched, 1, 5);
  events.back().old_center_world = Eigen::Vector3d(1.0, 1.0, 1.0);
  events.back().confidence = 0.75;
  add(EventType::kRemoved, EventReason::kSeenThrough, 2, 6);
  events.back().related = ObjectId(3);
  return events;
}

class ObjectServiceTest : public ::testing::TestWithParam<Transport> {
 protected:
  ObjectServiceTest() {
    MapDelta delta = Diff(MapSnapshot(truth_.scale), truth_);
    delta.events = MakeHistory(truth_);
    const MapKey key = service_.store().ListMaps()->front().key;
    LogAppend append{key, Timestamp::FromSeconds(1.0), {}, {}};
    for (std::uint64_t sequence = 1; sequence <= kRevision; ++sequence) {
      append.frames.emplace_back().sequence = MapSequence(sequence);
    }
    EXPECT_TRUE(service_.store().AppendFrames({append}).ok());
    const absl::Status committed =
        service_.store().CommitRevision(key, delta, Timestamp::FromSeconds(1.0));
    EXPECT_TRUE(committed.ok()) << committed;
    service_.Restart();
  }

  v1::ListObjectsRequest ObjectsRequest() const {
    v1::ListObjectsRequest request;
    request.set_map(map_);
    return request;
  }

  v1::ListEventsRequest EventsRequest() const {
    v1::ListEventsRequest request;
    request.set_map(map_);
    return request;
  }

  /// The ids on all pages.
  absl::StatusOr<std::vector<std::uint64_t>> ObjectIds(v1::ListObjectsRequest request) {
    std::vector<std::uint64_t> ids;
    do {
      v1::ListObjectsResponse response;
      absl::Status status = Call([&](auto* context) {
        return service_.queries().ListObjects(context, request, &response);
      });
      if (!status.ok()) return status;
      EXPECT_EQ(response.revision(), kRevision);
      if (request.page_size() > 0) {
        EXPECT_LE(response.objects_size(), static_cast<int>(request.page_size()));
      }
      for (const v1::Object& object : response.objects()) ids.push_back(object.id());
      request.set_page_token(response.next_page_token());
    } while (!request.page_token().empty());
    return ids;
  }

  /// The numbers on all pages.
  absl::StatusOr<std::vector<std::uint64_t>> EventNumbers(v1::ListEventsRequest request) {
    std::vector<std::uint64_t> numbers;
    do {
      v1::ListEventsResponse response;
      absl::Status status = Call([&](auto* context) {
        return service_.queries().ListEvents(context, request, &response);
      });
      if (!status.ok()) return status;
      EXPECT_EQ(response.revision(), kRevision);
      for (const v1::ObjectEvent& event : response.events()) numbers.push_back(event.number());
      request.set_page_token(response.next_page_token());
    } while (!request.page_token().empty());
    return numbers;
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

  const MapSnapshot truth_ = MakeMap();
  TestService service_{GetParam()};
  const std::string map_ = service_.CreateMap("hall");
};

INSTANTIATE_TEST_SUITE_P(Transports,
                         ObjectServiceTest,
                         ::testing::Values(Transport::kInProcess, Transport::kLoopback),
                         TransportName);

using Numbers = std::vector<std::uint64_t>;

TEST_P(ObjectServiceTest, AnObjectIsToldAsTheMapHasIt) {
  v1::GetObjectRequest request;
  request.set_map(map_);
  request.set_object_id(2);
  v1::GetObjectResponse response;
  const auto get = [&](auto* context) {
    return service_.queries().GetObject(context, request, &response);
  };
  ASSERT_TRUE(Call(get).ok());
  EXPECT_EQ(response.revision(), kRevision);
  const MapObject& truth = *truth_.objects.at(ObjectId(2));
  const absl::StatusOr<ObjectState> state = FromProto(response.object());
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_EQ(*state, static_cast<const ObjectState&>(truth));
  EXPECT_EQ(response.object().leaves(), truth.volume->leaf_count());
  EXPECT_EQ(response.object().class_confidence(), 0.75);
  for (const std::uint64_t id : {0U, 5U}) {
    request.set_object_id(id);
    EXPECT_THAT(Call(get), IsError(StatusCode::kNotFound, "NOT_FOUND", "object_id"));
  }
  request.set_map("tenants/test/maps/none");
  EXPECT_THAT(Call(get), IsError(StatusCode::kNotFound, "NOT_FOUND", "map"));
}

TEST_P(ObjectServiceTest, PresentObjectsAreListedOthersOnDemand) {
  EXPECT_EQ(*ObjectIds(ObjectsRequest()), (Numbers{1, 3}));
  v1::ListObjectsRequest request = ObjectsRequest();
  request.set_include_archived(true);
  EXPECT_EQ(*ObjectIds(request), (Numbers{1, 2, 3}));
  request.set_include_tentative(true);
  EXPECT_EQ(*ObjectIds(request), (Numbers{1, 2, 3, 4}));
  request.set_page_size(1);
  EXPECT_EQ(*ObjectIds(request), (Numbers{1, 2, 3, 4}));
}

TEST_P(ObjectServiceTest, EveryFilterOfObjectsCounts) {
  v1::ListObjectsRequest request = ObjectsRequest();
  request.add_class_ids(103);
  request.add_class_ids(7);
  EXPECT_EQ(*ObjectIds(request), (Numbers{3}));

  request = ObjectsRequest();
  request.set_min_stationarity(0.8);
  EXPECT_EQ(*ObjectIds(request), (Numbers{1}));
  request.set_min_stationarity(0.75);
  EXPECT_EQ(*ObjectIds(request), (Numbers{1, 3})) << "the bound itself passes";

  request = ObjectsRequest();
  request.set_changed_since(1);
  EXPECT_EQ(*ObjectIds(request), (Numbers{3}));

  request = ObjectsRequest();
  const Eigen::Vector3d corner = truth_.objects.at(ObjectId(1))->cuboid.T_world_cuboid() *
                                 Eigen::Vector3d(0.199, 0.149, 0.149);
  *request.mutable_box() = ToProto(Eigen::AlignedBox3d(corner, Eigen::Vector3d(2.0, 2.0, 2.0)));
  EXPECT_EQ(*ObjectIds(request), (Numbers{1, 3}));
  *request.mutable_box() =
      ToProto(Eigen::AlignedBox3d(corner + Eigen::Vector3d(0.0, 0.02, 0.0), corner.array() + 0.1));
  EXPECT_EQ(*ObjectIds(request), Numbers{});
}

TEST_P(ObjectServiceTest, WrongFiltersOfObjectsAreNamed) {
  v1::ListObjectsRequest request = ObjectsRequest();
  request.add_class_ids(1);
  request.add_class_ids(65'536);
  EXPECT_THAT(ObjectIds(request).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "class_ids[1]"));
  request.mutable_class_ids()->Resize(1001, 1);
  EXPECT_THAT(ObjectIds(request).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "class_ids"));
  for (const double stationarity : {-0.1, 1.1, kNan}) {
    request = ObjectsRequest();
    request.set_min_stationarity(stationarity);
    EXPECT_THAT(ObjectIds(request).status(),
                IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "min_stationarity"));
  }
  request = ObjectsRequest();
  request.mutable_box();
  EXPECT_THAT(ObjectIds(request).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "box.min_m"));
  request = ObjectsRequest();
  request.set_page_size(1001);
  EXPECT_THAT(ObjectIds(request).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "page_size"));
  request = ObjectsRequest();
  request.set_page_token("nonsense");
  EXPECT_THAT(ObjectIds(request).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_PAGE_TOKEN", "page_token"));
}

TEST_P(ObjectServiceTest, EventsComeInTheirOrderAndWhole) {
  const v1::ListEventsRequest request = EventsRequest();
  v1::ListEventsResponse response;
  ASSERT_TRUE(Call([&](auto* context) {
                return service_.queries().ListEvents(context, request, &response);
              }).ok());
  const std::vector<ObjectEvent> truth = MakeHistory(truth_);
  ASSERT_EQ(response.events_size(), static_cast<int>(truth.size()));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const v1::ObjectEvent& message = response.events(static_cast<int>(i));
    EXPECT_EQ(message.number(), i + 1);
    const absl::StatusOr<ObjectEvent> event = FromProto(message);
    ASSERT_TRUE(event.ok()) << event.status();
    EXPECT_EQ(*event, truth[i]);
  }
}

TEST_P(ObjectServiceTest, EventsComeInPages) {
  v1::ListEventsRequest request = EventsRequest();
  request.set_page_size(2);
  EXPECT_EQ(*EventNumbers(request), (Numbers{1, 2, 3, 4, 5}));
  request.set_first_number(3);
  EXPECT_EQ(*EventNumbers(request), (Numbers{3, 4, 5}));
  request.set_first_number(6);
  EXPECT_EQ(*EventNumbers(request), Numbers{});
  request.set_first_number(std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(*EventNumbers(request), Numbers{});
}

TEST_P(ObjectServiceTest, EveryFilterOfEventsCounts) {
  v1::ListEventsRequest request = EventsRequest();
  request.add_types(v1::EVENT_TYPE_MOVED);
  request.add_types(v1::EVENT_TYPE_REMOVED);
  EXPECT_EQ(*EventNumbers(request), (Numbers{4, 5}));
  request = EventsRequest();
  request.add_object_ids(3);
  EXPECT_EQ(*EventNumbers(request), (Numbers{3, 5})) << "related ones too";
  request = EventsRequest();
  request.add_class_ids(101);
  EXPECT_EQ(*EventNumbers(request), (Numbers{1, 4}));
  request = EventsRequest();
  request.set_changed_since(4);
  EXPECT_EQ(*EventNumbers(request), (Numbers{4, 5}));
  request = EventsRequest();
  *request.mutable_start_time() = ToProto(Timestamp::FromSeconds(140.0));
  EXPECT_EQ(*EventNumbers(request), (Numbers{3, 4, 5}));
  request.set_page_size(1);
  request.add_types(v1::EVENT_TYPE_CREATED);
  EXPECT_EQ(*EventNumbers(request), (Numbers{3}));
}

TEST_P(ObjectServiceTest, WrongFiltersOfEventsAreNamed) {
  v1::ListEventsRequest request = EventsRequest();
  request.add_types(v1::EVENT_TYPE_MOVED);
  request.add_types(v1::EVENT_TYPE_UNSPECIFIED);
  EXPECT_THAT(EventNumbers(request).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "types[1]"));
  request = EventsRequest();
  request.mutable_object_ids()->Resize(1001, 1);
  EXPECT_THAT(EventNumbers(request).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "object_ids"));
  request = EventsRequest();
  request.mutable_start_time()->set_nanos(-1);
  EXPECT_THAT(EventNumbers(request).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_TIMESTAMP", "start_time.nanos"));
  request = EventsRequest();
  request.set_page_token("nonsense");
  EXPECT_THAT(EventNumbers(request).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_PAGE_TOKEN", "page_token"));
}

TEST_P(ObjectServiceTest, PointsAndRaysSeeBackgroundAndPresentObjects) {
  const Eigen::Isometry3d T_world_box = truth_.objects.at(ObjectId(3))->T_world_object.ToIsometry();
  v1::SampleDistanceRequest points;
  points.set_map(map_);
  *points.add_points_m() = ToProto(Eigen::Vector3d(T_world_box * Eigen::Vector3d(0.25, 0, 0)));
  *points.add_points_m() = ToProto(Eigen::Vector3d(0.0, 0.0, 0.05));
  // Where the archived box stood.
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
  EXPECT_FALSE(samples.samples(2).known());

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
  EXPECT_TRUE(hits.hits(1).hit());
  EXPECT_EQ(hits.hits(1).object_id(), 0U) << "an archived box stops no ray";
}

TEST_P(ObjectServiceTest, SectionsHoldObjectsWithTheirLeaves) {
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
      ASSERT_EQ(leaf.packed(), PackLeaf(FindLeaf(truth_, key), truth_.scale));
      ++leaves[leaf.object_id()];
    }
  }
  EXPECT_EQ(leaves.size(), 3U);
  EXPECT_EQ(leaves[0], truth_.background.leaf_count());
  EXPECT_EQ(leaves[3], truth_.objects.at(ObjectId(3))->volume->leaf_count());
  EXPECT_EQ(leaves[0] + leaves[1] + leaves[3], service_.GetMap(map_)->state().leaves());

  // A box around the third object's upper half: neither the floor nor other objects.
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

TEST_P(ObjectServiceTest, ExportsHoldTheChosenVolumes) {
  const auto size = [&](v1::ExportFormat format, const std::vector<std::uint64_t>& ids) {
    v1::ExportMapRequest request;
    request.set_map(map_);
    request.set_format(format);
    for (const std::uint64_t id : ids) request.add_object_ids(id);
    return service_.Export(request)->size();
  };
  for (const v1::ExportFormat format :
       {v1::EXPORT_FORMAT_PLY, v1::EXPORT_FORMAT_GLB, v1::EXPORT_FORMAT_VDB}) {
    EXPECT_EQ(size(format, {}), size(format, {3, 1, 0, 1})) << "what the map shows";
    EXPECT_LT(size(format, {0}), size(format, {0, 1}));
    EXPECT_LT(size(format, {2}), size(format, {2, 3}));
    EXPECT_GT(size(format, {2}), 1000U) << "archived objects too";
  }
}

TEST_P(ObjectServiceTest, CountsIncludeObjects) {
  const MapCounts truth = CountMap(truth_);
  const absl::StatusOr<v1::Map> map = service_.GetMap(map_);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->state().present_objects(), 2U);
  EXPECT_EQ(map->state().archived_objects(), 1U);
  EXPECT_EQ(map->state().leaves(), truth.leaves);
  EXPECT_EQ(map->state().voxels(), truth.voxels);
  EXPECT_GT(map->state().memory_bytes(), truth_.background.memory_bytes());
}

}  // namespace
}  // namespace steadymap

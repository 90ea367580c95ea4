// Tests the service responses about objects and their history.

#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "proto/convert_event.h"
#include "proto/convert_geometry.h"
#include "proto/convert_object.h"
#include "tests/contract/object_map.h"
#include "tests/contract/test_service.h"
#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kNan;

using absl::StatusCode;

class ObjectServiceTest : public ::testing::TestWithParam<Transport> {
 protected:
  ObjectServiceTest() { StoreObjectMap(&service_); }

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

  /// Returns the ids on all pages.
  absl::StatusOr<std::vector<std::uint64_t>> ObjectIds(v1::ListObjectsRequest request) {
    std::vector<std::uint64_t> ids;
    do {
      v1::ListObjectsResponse response;
      absl::Status status = Call([&](auto* context) {
        return service_.queries().ListObjects(context, request, &response);
      });
      if (!status.ok()) return status;
      EXPECT_EQ(response.revision(), kObjectMapRevision);
      if (request.page_size() > 0) {
        EXPECT_LE(response.objects_size(), static_cast<int>(request.page_size()));
      }
      for (const v1::Object& object : response.objects()) ids.push_back(object.id());
      request.set_page_token(response.next_page_token());
    } while (!request.page_token().empty());
    return ids;
  }

  /// Returns the numbers on all pages.
  absl::StatusOr<std::vector<std::uint64_t>> EventNumbers(v1::ListEventsRequest request) {
    std::vector<std::uint64_t> numbers;
    do {
      v1::ListEventsResponse response;
      absl::Status status = Call([&](auto* context) {
        return service_.queries().ListEvents(context, request, &response);
      });
      if (!status.ok()) return status;
      EXPECT_EQ(response.revision(), kObjectMapRevision);
      for (const v1::ObjectEvent& event : response.events()) numbers.push_back(event.number());
      request.set_page_token(response.next_page_token());
    } while (!request.page_token().empty());
    return numbers;
  }

  const MapSnapshot truth_ = MakeObjectMap();
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
  EXPECT_EQ(response.revision(), kObjectMapRevision);
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

TEST_P(ObjectServiceTest, AnObjectIsFoundByItsName) {
  v1::GetObjectRequest request;
  request.set_name(map_ + "/objects/2");
  v1::GetObjectResponse response;
  const auto get = [&](auto* context) {
    return service_.queries().GetObject(context, request, &response);
  };
  ASSERT_TRUE(Call(get).ok());
  EXPECT_EQ(response.object().id(), 2U);
  request.set_name(map_ + "/objects/5");
  EXPECT_THAT(Call(get), IsError(StatusCode::kNotFound, "NOT_FOUND", "name"));
  request.set_name("tenants/test/maps/none/objects/2");
  EXPECT_THAT(Call(get), IsError(StatusCode::kNotFound, "NOT_FOUND", "name"));
  for (const std::string& wrong : {map_, map_ + "/objects/two", std::string("objects/2")}) {
    request.set_name(wrong);
    EXPECT_THAT(Call(get), IsError(StatusCode::kInvalidArgument, "BAD_NAME", "name")) << wrong;
  }
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
  const std::vector<ObjectEvent> truth = MakeObjectHistory(truth_);
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

}  // namespace
}  // namespace steadymap

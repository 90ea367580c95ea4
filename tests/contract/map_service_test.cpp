#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"

namespace steadymap {
namespace {

using absl::StatusCode;

class MapServiceTest : public ::testing::TestWithParam<Transport> {
 protected:
  absl::Status Create(const v1::CreateMapRequest& request, v1::Map* map = nullptr) {
    v1::Map ignored;
    return Call([&](auto* context) {
      return service_.maps().CreateMap(context, request, map != nullptr ? map : &ignored);
    });
  }

  absl::Status Update(const v1::Map& map, const std::vector<std::string>& paths, v1::Map* updated) {
    v1::UpdateMapRequest request;
    *request.mutable_map() = map;
    for (const std::string& path : paths) request.mutable_update_mask()->add_paths(path);
    return Call(
        [&](auto* context) { return service_.maps().UpdateMap(context, request, updated); });
  }

  absl::Status List(const v1::ListMapsRequest& request, v1::ListMapsResponse* response) {
    response->Clear();
    return Call(
        [&](auto* context) { return service_.maps().ListMaps(context, request, response); });
  }

  static v1::CreateMapRequest Request() {
    v1::CreateMapRequest request;
    request.set_parent("tenants/test");
    request.set_map_id("hall");
    return request;
  }

  TestService service_{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Transports,
                         MapServiceTest,
                         ::testing::Values(Transport::kInProcess, Transport::kLoopback),
                         TransportName);

TEST_P(MapServiceTest, NewMapHasTheDefaultsAndIsEmpty) {
  v1::Map map;
  ASSERT_TRUE(Create(Request(), &map).ok());
  EXPECT_EQ(map.name(), "tenants/test/maps/hall");
  EXPECT_DOUBLE_EQ(map.config().voxel_size_m(), 0.05);
  EXPECT_DOUBLE_EQ(map.config().truncation_m(), 3 * 0.05);
  EXPECT_DOUBLE_EQ(map.config().max_depth_m(), 3.0);
  EXPECT_EQ(map.config().policy(), v1::UPDATE_POLICY_STATIC);
  EXPECT_EQ(map.config().classes_size(), 16);
  EXPECT_EQ(map.retention().frame_log_age().seconds(), RetentionOptions().frame_log_age.count());
  EXPECT_FALSE(map.etag().empty());
  EXPECT_FALSE(map.incarnation().empty());
  EXPECT_TRUE(map.has_create_time());
  EXPECT_EQ(map.state().revision(), 0U);
  EXPECT_FALSE(map.state().has_last_capture_time());
}

TEST_P(MapServiceTest, SameNameTwiceIsRefused) {
  ASSERT_TRUE(Create(Request()).ok());
  EXPECT_THAT(Create(Request()), IsError(StatusCode::kAlreadyExists, "ALREADY_EXISTS", "map_id"));
}

TEST_P(MapServiceTest, SameRequestTwiceReturnsTheMap) {
  v1::CreateMapRequest request = Request();
  request.set_request_id("try-1");
  v1::Map first;
  v1::Map second;
  ASSERT_TRUE(Create(request, &first).ok());
  ASSERT_TRUE(Create(request, &second).ok());
  EXPECT_EQ(first.incarnation(), second.incarnation());
  request.mutable_map()->mutable_config()->set_voxel_size_m(0.1);
  EXPECT_EQ(Create(request).code(), StatusCode::kAlreadyExists);
}

TEST_P(MapServiceTest, WrongFieldsOfANewMapAreNamed) {
  const auto refusal = [this](const std::function<void(v1::CreateMapRequest*)>& spoil) {
    v1::CreateMapRequest request = Request();
    spoil(&request);
    return Create(request);
  };
  using Request = v1::CreateMapRequest;
  EXPECT_THAT(refusal([](Request* r) { r->set_parent("test"); }),
              IsError(StatusCode::kInvalidArgument, "BAD_NAME", "parent"));
  EXPECT_THAT(refusal([](Request* r) { r->set_map_id("Hall"); }),
              IsError(StatusCode::kInvalidArgument, "BAD_NAME", "map_id"));
  EXPECT_THAT(refusal([](Request* r) { r->set_request_id(std::string(65, 'x')); }),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "request_id"));
  EXPECT_THAT(
      refusal([](Request* r) { r->mutable_map()->set_display_name(std::string(129, 'x')); }),
      IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.display_name"));
  EXPECT_THAT(
      refusal([](Request* r) { r->mutable_map()->mutable_config()->set_voxel_size_m(1e9); }),
      IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.config.voxel_size_m"));
  EXPECT_THAT(refusal([](Request* r) {
                r->mutable_map()->mutable_config()->set_voxel_size_m(
                    std::numeric_limits<double>::quiet_NaN());
              }),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.config.voxel_size_m"));
  EXPECT_THAT(refusal([](Request* r) { r->mutable_map()->mutable_config()->set_truncation_m(-1); }),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.config.truncation_m"));
  EXPECT_THAT(refusal([](Request* r) {
                r->mutable_map()->mutable_config()->set_policy(static_cast<v1::UpdatePolicy>(7));
              }),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.config.policy"));
  EXPECT_THAT(
      refusal([](Request* r) { r->mutable_map()->mutable_config()->add_classes()->set_id(70000); }),
      IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.config.classes[0].id"));
  EXPECT_THAT(refusal([](Request* r) {
                r->mutable_map()->mutable_retention()->mutable_frame_log_age()->set_seconds(-1);
              }),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.retention.frame_log_age"));
}

TEST_P(MapServiceTest, TheLargestClassTableIsTakenAndOneMoreRowRefused) {
  v1::CreateMapRequest request;
  request.set_parent("tenants/test");
  request.set_map_id("hall");
  for (std::uint32_t i = 0; i < 4096; ++i) {
    v1::SemanticClass* row = request.mutable_map()->mutable_config()->add_classes();
    row->set_id(65'535 - i);
    row->set_name(std::string(64, 'x'));
    row->set_motion(v1::CLASS_MOTION_SEMI_STATIC);
    row->set_in_background(true);
  }
  v1::Map map;
  const auto create = [&](auto* context) {
    return service_.maps().CreateMap(context, request, &map);
  };
  const absl::Status created = Call(create);
  EXPECT_TRUE(created.ok()) << created;
  EXPECT_EQ(map.config().classes_size(), 4096);
  request.set_map_id("yard");
  request.mutable_map()->mutable_config()->add_classes()->set_name("one more");
  EXPECT_THAT(Call(create),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.config.classes"));
}

TEST_P(MapServiceTest, UnknownMapIsNotFound) {
  EXPECT_THAT(service_.GetMap("tenants/test/maps/none").status(),
              IsError(StatusCode::kNotFound, "NOT_FOUND", "name"));
  EXPECT_THAT(service_.GetMap("nonsense").status(),
              IsError(StatusCode::kInvalidArgument, "BAD_NAME", "name"));
  EXPECT_THAT(service_.DeleteMap("tenants/test/maps/none"),
              IsError(StatusCode::kNotFound, "NOT_FOUND", "name"));
}

TEST_P(MapServiceTest, ReadMaskKeepsWhatItNames) {
  v1::GetMapRequest request;
  request.set_name(service_.CreateMap("hall"));
  request.mutable_read_mask()->add_paths("etag");
  request.mutable_read_mask()->add_paths("config.voxel_size_m");
  v1::Map map;
  const auto get = [&](auto* context) { return service_.maps().GetMap(context, request, &map); };
  ASSERT_TRUE(Call(get).ok());
  EXPECT_FALSE(map.etag().empty());
  EXPECT_GT(map.config().voxel_size_m(), 0.0);
  EXPECT_TRUE(map.name().empty());
  EXPECT_EQ(map.config().classes_size(), 0);
  request.mutable_read_mask()->add_paths("colour");
  EXPECT_THAT(Call(get), IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "read_mask"));
}

TEST_P(MapServiceTest, PagesHoldEveryMapOnceInOrder) {
  for (const char* id : {"e", "b", "d", "a", "c"}) service_.CreateMap(id);
  v1::ListMapsRequest request;
  request.set_parent("tenants/test");
  request.set_page_size(2);
  v1::ListMapsResponse response;
  std::string ids;
  do {
    ASSERT_TRUE(List(request, &response).ok());
    ASSERT_LE(response.maps_size(), 2);
    for (const v1::Map& map : response.maps()) ids += map.name().back();
    request.set_page_token(response.next_page_token());
  } while (!response.next_page_token().empty());
  EXPECT_EQ(ids, "abcde");
  request.set_parent("tenants/other");
  ASSERT_TRUE(List(request, &response).ok());
  EXPECT_EQ(response.maps_size(), 0);
}

TEST_P(MapServiceTest, WrongPagesAreRefused) {
  for (const char* id : {"a", "b"}) service_.CreateMap(id);
  v1::ListMapsRequest request;
  request.set_parent("tenants/test");
  request.set_page_size(1);
  v1::ListMapsResponse response;
  ASSERT_TRUE(List(request, &response).ok());
  v1::ListMapsRequest other_tenant = request;
  other_tenant.set_parent("tenants/other");
  other_tenant.set_page_token(response.next_page_token());
  EXPECT_THAT(List(other_tenant, &response),
              IsError(StatusCode::kInvalidArgument, "BAD_PAGE_TOKEN", "page_token"));
  request.set_page_token("garbage");
  EXPECT_THAT(List(request, &response),
              IsError(StatusCode::kInvalidArgument, "BAD_PAGE_TOKEN", "page_token"));
  request.set_page_size(1001);
  EXPECT_THAT(List(request, &response),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "page_size"));
  request.set_parent("tenants/");
  EXPECT_THAT(List(request, &response),
              IsError(StatusCode::kInvalidArgument, "BAD_NAME", "parent"));
}

TEST_P(MapServiceTest, UpdateChangesWhatTheMaskNamesAndTheEtag) {
  v1::Map map = *service_.GetMap(service_.CreateMap("hall"));
  const std::string etag = map.etag();
  map.set_display_name("The hall");
  map.set_byte_budget(1000);
  v1::Map updated;
  ASSERT_TRUE(Update(map, {"display_name"}, &updated).ok());
  EXPECT_EQ(updated.display_name(), "The hall");
  EXPECT_EQ(updated.byte_budget(), 0U);
  EXPECT_NE(updated.etag(), etag);
  // The etag is outdated.
  EXPECT_THAT(Update(map, {"byte_budget"}, &updated),
              IsError(StatusCode::kAborted, "ETAG_MISMATCH", "map.etag"));
  map.clear_etag();
  map.mutable_retention()->mutable_frame_log_age()->set_seconds(7);
  ASSERT_TRUE(Update(map, {"byte_budget", "retention.frame_log_age"}, &updated).ok());
  EXPECT_EQ(updated.byte_budget(), 1000U);
  EXPECT_EQ(updated.retention().frame_log_age().seconds(), 7);
  map.mutable_max_commit_delay()->set_nanos(20'000'000);
  ASSERT_TRUE(Update(map, {"max_commit_delay"}, &updated).ok());
  EXPECT_EQ(updated.max_commit_delay().nanos(), 20'000'000);
  for (const int nanos : {1, -1'000'000}) {
    map.mutable_max_commit_delay()->set_nanos(nanos);
    EXPECT_THAT(Update(map, {"max_commit_delay"}, &updated),
                IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.max_commit_delay"));
  }
  service_.Restart();
  EXPECT_EQ(service_.GetMap(map.name())->max_commit_delay().nanos(), 20'000'000);
  EXPECT_EQ(service_.GetMap(map.name())->display_name(), "The hall");
}

TEST_P(MapServiceTest, WhatIsFixedCannotBeUpdated) {
  const v1::Map map = *service_.GetMap(service_.CreateMap("hall"));
  v1::Map updated;
  EXPECT_THAT(Update(map, {"config"}, &updated),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "update_mask"));
  EXPECT_THAT(Update(map, {}, &updated),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "update_mask"));
  EXPECT_EQ(service_.GetMap(map.name())->etag(), map.etag());
}

TEST_P(MapServiceTest, LabelsAndWorldFrameAreKept) {
  v1::CreateMapRequest request = Request();
  (*request.mutable_map()->mutable_labels())["site"] = "north";
  v1::WorldFrame& frame = *request.mutable_map()->mutable_world_frame();
  frame.set_description("x along the gate");
  frame.set_floor("2");
  frame.mutable_anchor()->set_latitude_deg(48.1);
  frame.mutable_anchor()->set_heading_deg(270.0);
  v1::Map map;
  ASSERT_TRUE(Create(request, &map).ok());
  map.mutable_labels()->clear();
  (*map.mutable_labels())["shift"] = "";
  v1::Map updated;
  ASSERT_TRUE(Update(map, {"labels"}, &updated).ok());
  service_.Restart();
  const v1::Map kept = *service_.GetMap(map.name());
  EXPECT_EQ(kept.labels_size(), 1);
  EXPECT_TRUE(kept.labels().contains("shift"));
  EXPECT_EQ(kept.world_frame().SerializeAsString(), frame.SerializeAsString());
  map.clear_etag();
  (*map.mutable_labels())["Not an id"] = "x";
  EXPECT_THAT(Update(map, {"labels"}, &updated),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.labels"));
  map.mutable_world_frame()->mutable_anchor()->set_heading_deg(360.0);
  EXPECT_THAT(Update(map, {"world_frame"}, &updated),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.world_frame.anchor"));
}

TEST_P(MapServiceTest, ClassesCanBeAddedAndNotChanged) {
  v1::Map map = *service_.GetMap(service_.CreateMap("hall"));
  const int present = map.config().classes_size();
  v1::SemanticClass* added = map.mutable_config()->add_classes();
  added->set_id(500);
  added->set_name("robot dog");
  added->set_motion(v1::CLASS_MOTION_DYNAMIC);
  v1::Map updated;
  ASSERT_TRUE(Update(map, {"config.classes"}, &updated).ok());
  EXPECT_EQ(updated.config().classes_size(), present + 1);
  EXPECT_NE(updated.etag(), map.etag());
  EXPECT_EQ(updated.state().durable_map_seq(), 1U) << "an entry of the log";
  map.clear_etag();
  ASSERT_TRUE(Update(map, {"config.classes"}, &updated).ok()) << "nothing is left to add";
  EXPECT_EQ(updated.state().durable_map_seq(), 1U);
  v1::FrameBatch batch = MakeBatch(1, 1);
  ASSERT_TRUE(UploadAndClose(&service_, {map.name()}, batch).ok());
  EXPECT_EQ(service_.GetMap(map.name())->state().integrated_map_seq(), 2U);
  service_.Restart();
  EXPECT_EQ(service_.GetMap(map.name())->config().classes(present).name(), "robot dog");
  map.mutable_config()->mutable_classes(3)->set_name("another name");
  EXPECT_THAT(Update(map, {"config.classes"}, &updated),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.config.classes"));
  map.mutable_config()->clear_classes();
  EXPECT_THAT(Update(map, {"config.classes"}, &updated),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "map.config.classes"));
}

TEST_P(MapServiceTest, ChangesThatAreSentAgainChangeNothing) {
  const v1::Map map = *service_.GetMap(service_.CreateMap("hall"));
  v1::UpdateMapRequest update;
  *update.mutable_map() = map;
  update.mutable_map()->set_display_name("The hall");
  update.mutable_update_mask()->add_paths("display_name");
  update.set_request_id("change-1");
  v1::Map first;
  v1::Map second;
  ASSERT_TRUE(
      Call([&](auto* context) { return service_.maps().UpdateMap(context, update, &first); }).ok());
  service_.Restart();
  ASSERT_TRUE(
      Call([&](auto* context) { return service_.maps().UpdateMap(context, update, &second); }).ok())
      << "though the etag is of the map before";
  EXPECT_EQ(second.etag(), first.etag());
  v1::DeleteMapRequest remove;
  remove.set_name(map.name());
  remove.set_request_id("change-2");
  google::protobuf::Empty response;
  const auto call = [&](auto* context) {
    return service_.maps().DeleteMap(context, remove, &response);
  };
  EXPECT_TRUE(Call(call).ok());
  EXPECT_TRUE(Call(call).ok());
  remove.set_request_id("change-3");
  EXPECT_THAT(Call(call), IsError(StatusCode::kNotFound, "NOT_FOUND", "name"));
}

TEST_P(MapServiceTest, DeleteWithAnOldEtagIsRefused) {
  const v1::Map map = *service_.GetMap(service_.CreateMap("hall"));
  v1::DeleteMapRequest request;
  request.set_name(map.name());
  request.set_etag("old");
  google::protobuf::Empty response;
  const auto remove = [&](auto* context) {
    return service_.maps().DeleteMap(context, request, &response);
  };
  EXPECT_THAT(Call(remove), IsError(StatusCode::kAborted, "ETAG_MISMATCH", "etag"));
  request.set_etag(map.etag());
  EXPECT_TRUE(Call(remove).ok());
  EXPECT_EQ(service_.GetMap(map.name()).status().code(), StatusCode::kNotFound);
}

TEST_P(MapServiceTest, NameIsFreeAgainAfterADelete) {
  const std::string name = service_.CreateMap("hall");
  ASSERT_TRUE(UploadAndClose(&service_, {name}, MakeBatch(1, 2)).ok());
  const v1::Map before = *service_.GetMap(name);
  ASSERT_TRUE(service_.DeleteMap(name).ok());
  service_.CreateMap("hall");
  const v1::Map after = *service_.GetMap(name);
  EXPECT_EQ(after.state().revision(), 0U);
  EXPECT_NE(after.incarnation(), before.incarnation());
  EXPECT_NE(after.etag(), before.etag());
}

}  // namespace
}  // namespace steadymap

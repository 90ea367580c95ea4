#include "server/query/query_responses.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "core/types/query_work.h"
#include "proto/convert_geometry.h"
#include "server/query/map_export.h"
#include "server/query/map_section.h"
#include "server/query/object_responses.h"
#include "server/query/query_selection.h"
#include "tests/server/store/store_builder.h"
#include "tests/support/analytic_map.h"
#include "tests/support/memory_store.h"

namespace steadymap {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

/// Rays slightly above the floor, which they never hit.
v1::CastRaysRequest GrazingRays(int count) {
  v1::CastRaysRequest request;
  for (int i = 0; i < count; ++i) {
    v1::Ray* ray = request.add_rays();
    *ray->mutable_origin_m() = ToProto(Eigen::Vector3d(-1.9, 0.001 * (i % 1000), 0.05));
    ray->mutable_direction()->set_x(1.0);
  }
  return request;
}

v1::SampleDistanceRequest PointsAboveFloor(int count) {
  v1::SampleDistanceRequest request;
  for (int i = 0; i < count; ++i) {
    *request.add_points_m() = ToProto(Eigen::Vector3d(0.001 * (i % 1000), 0.0, 0.05));
  }
  return request;
}

/// Returns a cancellation that becomes true after `times` calls, and counts the calls.
Cancellation CancelledAfter(std::size_t times, std::size_t* asked) {
  *asked = 0;
  return Cancellation([times, asked] { return (*asked)++ >= times; });
}

TEST(AnswerCastRays, EndsWithinAThousandRaysOnceItIsCancelled) {
  const MapSnapshot map = testing::FloorMap();
  const v1::CastRaysRequest request = GrazingRays(2000);
  v1::CastRaysResponse whole;
  std::size_t of_whole = 0;
  ASSERT_TRUE(
      AnswerCastRays(map, request, CancelledAfter(~std::size_t{0}, &of_whole), &whole).ok());
  EXPECT_EQ(whole.hits_size(), 2000);
  ASSERT_GT(of_whole, 20U);
  for (std::size_t wanted_for = 0; wanted_for < of_whole; wanted_for += 5) {
    v1::CastRaysResponse response;
    std::size_t asked = 0;
    const absl::Status status =
        AnswerCastRays(map, request, CancelledAfter(wanted_for, &asked), &response);
    EXPECT_TRUE(absl::IsCancelled(status)) << status;
    EXPECT_EQ(asked, wanted_for + 1) << "work continued after the cancellation";
    EXPECT_LE(static_cast<std::size_t>(response.hits_size()),
              2000 * (wanted_for + 1) / of_whole + 1000);
  }
}

TEST(AnswerCastRays, MoreWorkThanACallMayTakeIsRefused) {
  const MapSnapshot map = testing::FloorMap();
  v1::CastRaysResponse response;
  const absl::Status status =
      AnswerCastRays(map, GrazingRays(100), Cancellation(), &response, /*max_steps=*/1000);
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(ReasonOf(status), "WORK_LIMIT");
  EXPECT_EQ(FieldOf(status), "rays");
  EXPECT_TRUE(AnswerCastRays(map, GrazingRays(2), Cancellation(), &response, 1000).ok());
}

TEST(AnswerSampleDistance, EndsOnceItIsCancelledOrTooMuch) {
  const MapSnapshot map = testing::BoxOverFloor();
  const v1::SampleDistanceRequest request = PointsAboveFloor(10'000);
  for (const std::size_t wanted_for : {0U, 1U, 4U}) {
    v1::SampleDistanceResponse response;
    std::size_t asked = 0;
    EXPECT_TRUE(absl::IsCancelled(
        AnswerSampleDistance(map, request, CancelledAfter(wanted_for, &asked), &response)));
    EXPECT_EQ(asked, wanted_for + 1);
    EXPECT_LE(static_cast<std::uint64_t>(response.samples_size()),
              wanted_for * QueryWork::kStepsPerCheck + 1);
  }
  v1::SampleDistanceResponse response;
  const absl::Status status =
      AnswerSampleDistance(map, request, Cancellation(), &response, /*max_steps=*/5'000);
  EXPECT_EQ(ReasonOf(status), "WORK_LIMIT");
  EXPECT_EQ(FieldOf(status), "points_m");
}

/// A map of 600 visible objects.
class ManyObjects : public ::testing::Test {
 protected:
  ManyObjects() {
    for (std::uint64_t id = 1; id <= 600; ++id) Add(id);
    map_.revision = Revision(5);
  }

  void Add(std::uint64_t id, std::size_t votes = 1) {
    MapObject object;
    object.id = ObjectId(id);
    object.status = ObjectStatus::kPresent;
    object.volume = empty_;
    for (std::size_t i = 0; i < votes; ++i) {
      object.votes.push_back({ClassId(static_cast<std::uint16_t>(i)), 1.0});
    }
    map_.objects.insert_or_assign(object.id, std::make_shared<const MapObject>(object));
  }

  absl::StatusOr<v1::ListObjectsResponse> List(const v1::ListObjectsRequest& request,
                                               const Cancellation& cancellation = {}) const {
    v1::ListObjectsResponse response;
    absl::Status status = AnswerListObjects(MapKey(3), map_, request, cancellation, &response);
    if (!status.ok()) return status;
    return response;
  }

  const std::shared_ptr<const TsdfGrid> empty_ = std::make_shared<const TsdfGrid>();
  MapSnapshot map_;
};

TEST_F(ManyObjects, AListingEndsOnceItIsCancelled) {
  v1::ListObjectsRequest request;
  request.add_class_ids(7);  // No object has this class, so all are skipped.
  for (const std::size_t wanted_for : {0U, 1U, 2U}) {
    std::size_t asked = 0;
    EXPECT_TRUE(absl::IsCancelled(List(request, CancelledAfter(wanted_for, &asked)).status()));
    EXPECT_EQ(asked, wanted_for + 1);
  }
}

TEST_F(ManyObjects, ATokenGoesWithItsFiltersAlone) {
  v1::ListObjectsRequest request;
  request.set_page_size(2);
  request.set_page_token(List(request)->next_page_token());
  request.set_page_size(5);
  EXPECT_EQ(List(request)->objects(0).id(), 3U) << "the size of pages may change";
  std::vector<v1::ListObjectsRequest> changed(6, request);
  changed[0].add_class_ids(0);
  changed[1].mutable_box()->mutable_min_m();
  changed[1].mutable_box()->mutable_max_m()->set_x(1.0);
  changed[2].set_min_stationarity(0.1);
  changed[3].set_changed_since(1);
  changed[4].set_include_archived(true);
  changed[5].set_include_tentative(true);
  for (const v1::ListObjectsRequest& other : changed) {
    EXPECT_EQ(ReasonOf(List(other).status()), "BAD_PAGE_TOKEN") << other.ShortDebugString();
    EXPECT_EQ(FieldOf(List(other).status()), "page_token");
  }
}

TEST_F(ManyObjects, AListingGoesOnOverALaterRevision) {
  v1::ListObjectsRequest request;
  request.set_page_size(300);
  const v1::ListObjectsResponse first = *List(request);
  map_.objects.erase(ObjectId(2));
  map_.objects.erase(ObjectId(400));
  Add(601);
  map_.revision = Revision(6);
  request.set_page_token(first.next_page_token());
  request.set_page_size(1000);
  const v1::ListObjectsResponse second = *List(request);
  EXPECT_EQ(second.revision(), 6U);
  std::vector<std::uint64_t> ids;
  for (const v1::Object& object : second.objects()) ids.push_back(object.id());
  EXPECT_EQ(ids.size(), 300U) << "301 to 601 without 400";
  EXPECT_EQ(ids.front(), 301U);
  EXPECT_EQ(ids.back(), 601U);
}

TEST_F(ManyObjects, APageEndsAtItsBytes) {
  for (std::uint64_t id = 1; id <= 30; ++id) Add(id, /*votes=*/10'000);
  v1::ListObjectsRequest request;
  request.set_page_size(1000);
  std::uint64_t expected = 1;
  do {
    const v1::ListObjectsResponse page = *List(request);
    EXPECT_LT(page.ByteSizeLong(), 2 * kMiB);
    for (const v1::Object& object : page.objects()) EXPECT_EQ(object.id(), expected++);
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(expected, 601U);
}

/// A map with 12 000 integrated frames.
class ManyPoses : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kPoses = 12'000;

  ManyPoses() {
    map_ = store_.CreateMap(MakeMapRecord("test", "hall"))->key;
    Commit(0, kPoses);
  }

  void Commit(std::uint64_t from, std::uint64_t to) {
    EXPECT_TRUE(store_.Append(MakeAppend(map_, from + 1, to - from)).ok());
    const MapDelta delta = MakeDelta(from, to, {});
    CommitDetails details = MakeDetails(delta);
    for (FramePose& pose : details.poses) {
      pose.source = {std::string(63, 'r'), std::string(63, 's')};
    }
    EXPECT_TRUE(store_.CommitRevision(map_, delta, details).ok());
    snapshot_.revision = Revision(to);
  }

  absl::StatusOr<v1::ListFramePosesResponse> List(const v1::ListFramePosesRequest& request,
                                                  const Cancellation& cancellation = {}) {
    v1::ListFramePosesResponse response;
    absl::Status status =
        AnswerListFramePoses(store_, map_, snapshot_, request, cancellation, &response);
    if (!status.ok()) return status;
    return response;
  }

  MemoryStore store_;
  MapKey map_;
  MapSnapshot snapshot_;
};

TEST_F(ManyPoses, APageEndsAtItsBytes) {
  v1::ListFramePosesRequest request;
  request.set_page_size(10'000);
  std::uint64_t expected = 1;
  int pages = 0;
  do {
    const v1::ListFramePosesResponse page = *List(request);
    EXPECT_LT(page.ByteSizeLong(), kMiB + kMiB / 8);
    for (const v1::FramePose& pose : page.poses()) ASSERT_EQ(pose.map_seq(), expected++);
    request.set_page_token(page.next_page_token());
    ++pages;
  } while (!request.page_token().empty());
  EXPECT_EQ(expected, kPoses + 1);
  EXPECT_GT(pages, 2);
}

TEST_F(ManyPoses, PagesOfOneListingShowTheFramesOfTheFirst) {
  v1::ListFramePosesRequest request;
  request.set_page_size(10);
  request.set_page_token(List(request)->next_page_token());
  Commit(kPoses, kPoses + 5);
  std::uint64_t last = 0;
  request.set_page_size(10'000);
  do {
    const v1::ListFramePosesResponse page = *List(request);
    EXPECT_EQ(page.revision(), kPoses);
    last = page.poses().rbegin()->map_seq();
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(last, kPoses);
}

TEST_F(ManyPoses, ReadingEndsWithTheBatchOnceItIsCancelled) {
  v1::ListFramePosesRequest request;
  request.set_page_size(10'000);
  for (const std::size_t wanted_for : {0U, 1U, 3U}) {
    std::size_t asked = 0;
    EXPECT_TRUE(absl::IsCancelled(List(request, CancelledAfter(wanted_for, &asked)).status()));
    EXPECT_EQ(asked, wanted_for + 1);
  }
}

TEST(ObjectName, IsReadInBothForms) {
  v1::GetObjectRequest request;
  request.set_map("tenants/t/maps/m");
  request.set_object_id(12);
  EXPECT_EQ(ReadObjectName(request)->map, "tenants/t/maps/m");
  EXPECT_EQ(ReadObjectName(request)->object, ObjectId(12));
  request.Clear();
  request.set_name("tenants/t/maps/m/objects/12");
  EXPECT_EQ(ReadObjectName(request)->map, "tenants/t/maps/m");
  EXPECT_EQ(ReadObjectName(request)->object, ObjectId(12));
  EXPECT_EQ(ReadObjectName(request)->object_field, "name");
  request.set_map("tenants/t/maps/m");
  EXPECT_EQ(ReasonOf(ReadObjectName(request).status()), "BAD_VALUE") << "both at once";
}

TEST(ObjectName, HasOneSpelling) {
  for (const char* wrong : {"12",
                            "tenants/t/maps/m",
                            "tenants/t/maps/m/objects/",
                            "tenants/t/maps/m/objects/012",
                            "tenants/t/maps/m/objects/+12",
                            "tenants/t/maps/m/objects/ 12",
                            "tenants/t/maps/m/objects/12/",
                            "tenants/t/maps/m/objects/18446744073709551616",
                            "tenants/t/maps/m/events/12"}) {
    v1::GetObjectRequest request;
    request.set_name(wrong);
    const absl::Status status = ReadObjectName(request).status();
    EXPECT_EQ(ReasonOf(status), "BAD_NAME") << wrong;
    EXPECT_EQ(FieldOf(status), "name") << wrong;
  }
}

}  // namespace
}  // namespace steadymap

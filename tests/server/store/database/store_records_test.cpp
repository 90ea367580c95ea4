#include "server/store/database/store_records.h"

#include <cstdint>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/types/crc32c.h"
#include "core/types/error.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

using ::testing::HasSubstr;

constexpr ValuePlace kPlace{"leaf", "key"};

TEST(Seal, UnsealGivesThePayloadBack) {
  for (const std::string& payload : {std::string(), std::string("x"), std::string(100'000, '\0')}) {
    const std::string value = Seal(kPlace, payload);
    EXPECT_EQ(Unseal(kPlace, value).value(), payload);
  }
}

TEST(Unseal, FindsEveryFlippedBitAndNamesThePlace) {
  const std::string value = Seal(kPlace, "the payload");
  for (std::size_t bit = 0; bit < 8 * value.size(); ++bit) {
    std::string damaged = value;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    const absl::Status status = Unseal(kPlace, damaged).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << bit;
    EXPECT_EQ(ReasonOf(status), reason::kChecksum);
    EXPECT_THAT(std::string(status.message()), HasSubstr("column family leaf"));
    EXPECT_THAT(std::string(status.message()), HasSubstr("6b6579"));
  }
}

TEST(Unseal, FindsACutValue) {
  const std::string value = Seal(kPlace, "the payload");
  for (std::size_t length = 0; length < value.size(); ++length) {
    EXPECT_TRUE(absl::IsDataLoss(Unseal(kPlace, value.substr(0, length)).status())) << length;
  }
}

TEST(Unseal, FindsAGoodValueInTheWrongPlace) {
  const std::string value = Seal(kPlace, "the payload");
  EXPECT_TRUE(absl::IsDataLoss(Unseal({"leaf", "kez"}, value).status()));
  EXPECT_TRUE(absl::IsDataLoss(Unseal({"pose", "key"}, value).status()));
}

TEST(Unseal, RefusesANewerVersionAsNewerNotAsDamaged) {
  std::uint32_t crc = ExtendCrc32c(0,
                                   std::string("leaf\0key\x02"
                                               "new",
                                               12));
  std::string value = "\x02";
  for (int i = 0; i < 4; ++i, crc >>= 8) value += static_cast<char>(crc & 0xFFU);
  EXPECT_TRUE(absl::IsFailedPrecondition(Unseal(kPlace, value + "new").status()));
}

TEST(MapRecordFromProto, RefusesNumbersThatMeanNothing) {
  storage::v1::MapRecord proto = ToProto(MapRecord());
  ASSERT_TRUE(FromProto(proto).ok());
  storage::v1::MapRecord bad = proto;
  bad.mutable_config()->set_policy(9);
  EXPECT_TRUE(absl::IsDataLoss(FromProto(bad).status()));
  bad = proto;
  bad.mutable_config()->mutable_classes(0)->set_motion(0);
  EXPECT_TRUE(absl::IsDataLoss(FromProto(bad).status()));
  bad = proto;
  bad.mutable_config()->mutable_classes(0)->set_id(70'000);
  EXPECT_TRUE(absl::IsDataLoss(FromProto(bad).status()));
}

TEST(PoseFromProto, RefusesAPoseOfTheWrongLength) {
  storage::v1::PoseRecord proto = ToProto(FramePose());
  EXPECT_TRUE(FromProto(MapSequence{1}, proto).ok());
  proto.add_t_world_camera(1.0);
  EXPECT_TRUE(absl::IsDataLoss(FromProto(MapSequence{1}, proto).status()));
}

}  // namespace
}  // namespace steadymap

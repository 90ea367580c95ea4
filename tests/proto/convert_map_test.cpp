#include "proto/convert_map.h"

#include <cstdint>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/support/all_policies.h"

namespace steadymap {
namespace {

TEST(ConvertMapConfig, AbsentFieldsTakeTheDefaults) {
  const auto config = FromProto(v1::MapConfig());
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_DOUBLE_EQ(config->truncation_m, MapConfig().truncation_m);
  EXPECT_EQ(config->voxel_size_m, MapConfig().voxel_size_m);
  EXPECT_EQ(config->max_depth_m, MapConfig().max_depth_m);
  EXPECT_EQ(config->classes, TorwicClasses());
  EXPECT_EQ(config->policy, UpdatePolicy::kStatic);
}

TEST(ConvertMapConfig, PoliciesComeBack) {
  for (const UpdatePolicy policy : testing::kAllPolicies) {
    MapConfig config;
    config.policy = policy;
    EXPECT_EQ(FromProto(ToProto(config))->policy, policy);
  }
}

TEST(ConvertMapConfig, TruncationFollowsTheVoxelSize) {
  v1::MapConfig message;
  message.set_voxel_size_m(0.02);
  EXPECT_DOUBLE_EQ(FromProto(message)->truncation_m, 0.06);
}

TEST(ConvertMapConfig, ComesBack) {
  MapConfig config;
  config.voxel_size_m = 0.02;
  config.truncation_m = 0.08;
  config.max_depth_m = 7.0;
  config.policy = UpdatePolicy::kPocd;
  config.parameters = {{"change_noise_m", 0.03}, {"max_evidence", 20.0}};
  config.classes = {{ClassId(0), "floor", ClassMotion::kStatic},
                    {ClassId(9), "cart", ClassMotion::kSemiStatic},
                    {ClassId(65535), "person", ClassMotion::kDynamic}};
  EXPECT_EQ(*FromProto(ToProto(config)), config);
}

TEST(ConvertMapConfig, WrongFieldsAreNamed) {
  const auto field = [](const std::function<void(v1::MapConfig*)>& spoil) {
    v1::MapConfig message = ToProto(MapConfig());
    spoil(&message);
    const absl::Status status = FromProto(message).status();
    EXPECT_EQ(ReasonOf(status), "BAD_VALUE");
    return FieldOf(status);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(field([&](v1::MapConfig* m) { m->set_voxel_size_m(nan); }), "voxel_size_m");
  EXPECT_EQ(field([&](v1::MapConfig* m) { (*m->mutable_parameters())["speed"] = 1.0; }),
            "parameters[speed]");
  EXPECT_EQ(field([&](v1::MapConfig* m) { m->set_truncation_m(nan); }), "truncation_m");
  EXPECT_EQ(field([&](v1::MapConfig* m) { m->set_max_depth_m(-nan); }), "max_depth_m");
  EXPECT_EQ(field([](v1::MapConfig* m) { m->set_policy(static_cast<v1::UpdatePolicy>(77)); }),
            "policy");
  EXPECT_EQ(field([](v1::MapConfig* m) { m->mutable_classes(3)->set_id(65536); }), "classes[3].id");
  EXPECT_EQ(field([](v1::MapConfig* m) {
              m->mutable_classes(2)->set_motion(static_cast<v1::ClassMotion>(-1));
            }),
            "classes[2].motion");
  EXPECT_EQ(field([](v1::MapConfig* m) { m->mutable_classes(5)->set_id(4); }), "classes[5].id");
  EXPECT_EQ(field([](v1::MapConfig* m) { m->mutable_classes(5)->clear_name(); }),
            "classes[5].name");
}

TEST(ConvertMapConfig, ClassTablesHaveABoundWhateverTheirIds) {
  v1::MapConfig message;
  for (int i = 0; i < kMaxClasses; ++i) {
    v1::SemanticClass* row = message.add_classes();
    row->set_id(static_cast<std::uint32_t>(16 * i));
    row->set_name(std::string(64, 'x'));
  }
  EXPECT_TRUE(FromProto(message).ok());
  message.add_classes()->set_name("one more");
  const absl::Status status = FromProto(message).status();
  EXPECT_EQ(FieldOf(status), "classes");
  EXPECT_NE(status.message().find("at most 4096 rows, got 4097"), absl::string_view::npos)
      << status;
}

}  // namespace
}  // namespace steadymap

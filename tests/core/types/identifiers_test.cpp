#include "core/types/identifiers.h"

#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

TEST(IsValidId, AcceptsLowerCaseLettersDigitsAndDashes) {
  EXPECT_TRUE(IsValidId("a"));
  EXPECT_TRUE(IsValidId("hall-2"));
  EXPECT_TRUE(IsValidId(std::string(63, 'a')));
}

TEST(IsValidId, RefusesWhatCouldBeAPathOrAnEmptyKey) {
  for (const char* text : {"", "2hall", "Hall", "a/b", "..", "a.b", "a b", "-a", "a\n"}) {
    EXPECT_FALSE(IsValidId(text)) << text;
  }
  EXPECT_FALSE(IsValidId(std::string(64, 'a')));
}

TEST(MapName, RoundTripsThroughText) {
  const absl::StatusOr<MapName> name = MapName::Parse("tenants/acme/maps/hall-2");
  ASSERT_TRUE(name.ok()) << name.status();
  EXPECT_EQ(name->tenant, "acme");
  EXPECT_EQ(name->map, "hall-2");
  EXPECT_EQ(name->ToString(), "tenants/acme/maps/hall-2");
}

TEST(MapName, RefusesAnythingElseWithTheFieldsName) {
  for (const char* text : {"",
                           "hall",
                           "tenants/maps/x",
                           "tenants//maps/x",
                           "tenants/a/maps/",
                           "tenants/a/maps/b/objects/1",
                           "tenants/a/maps/../../etc"}) {
    const absl::StatusOr<MapName> name = MapName::Parse(text);
    ASSERT_FALSE(name.ok()) << text;
    EXPECT_EQ(ReasonOf(name.status()), reason::kBadName);
    EXPECT_EQ(FieldOf(name.status()), "name");
  }
}

}  // namespace
}  // namespace steadymap

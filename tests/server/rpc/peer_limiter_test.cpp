#include "server/rpc/peer_limiter.h"

#include <string>

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

const absl::Time kStart = absl::FromUnixSeconds(1'000'000);

class PeerLimiterTest : public ::testing::Test {
 protected:
  bool Take(const std::string& peer, absl::Duration after = absl::ZeroDuration()) {
    return limiter_.Take(peer, kStart + after).ok();
  }

  PeerLimiter limiter_{{.per_second = 2.0, .burst = 3.0}};
};

TEST_F(PeerLimiterTest, LetsABurstPassAndThenTheRate) {
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(Take("unix:"));
  const absl::Status refused = limiter_.Take("unix:", kStart);
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(refused), reason::kRateLimit);
  EXPECT_FALSE(Take("unix:", absl::Milliseconds(400)));
  EXPECT_TRUE(Take("unix:", absl::Milliseconds(500)));
  EXPECT_FALSE(Take("unix:", absl::Milliseconds(500)));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(Take("unix:", absl::Hours(1)));
  EXPECT_FALSE(Take("unix:", absl::Hours(1))) << "a bucket holds no more than the burst";
}

TEST_F(PeerLimiterTest, GoesOnAfterTheClockWasSetBack) {
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(Take("unix:"));
  EXPECT_FALSE(Take("unix:", -absl::Hours(1)));
  EXPECT_TRUE(Take("unix:", -absl::Hours(1) + absl::Seconds(1)));
}

TEST_F(PeerLimiterTest, PortsOfOneAddressShareItsBucket) {
  for (int port = 1; port <= 3; ++port) EXPECT_TRUE(Take(absl::StrCat("ipv4:10.0.0.7:", port)));
  EXPECT_FALSE(Take("ipv4:10.0.0.7:4"));
  EXPECT_TRUE(Take("ipv4:10.0.0.8:4"));
  for (int port = 1; port <= 3; ++port) EXPECT_TRUE(Take(absl::StrCat("ipv6:%5B::1%5D:", port)));
  EXPECT_FALSE(Take("ipv6:%5B::1%5D:4"));
  EXPECT_TRUE(Take("ipv6:%5B::2%5D:4"));
}

TEST_F(PeerLimiterTest, ManyAddressesAtOnceShareWhatIsLeft) {
  int taken = 0;
  for (int i = 0; i < 10'000; ++i) taken += Take(absl::StrCat("ipv4:", i, ":1")) ? 1 : 0;
  EXPECT_GE(taken, 4000);
  EXPECT_LE(taken, 4200);
  EXPECT_TRUE(Take("ipv4:new:1", absl::Minutes(1))) << "the others have been away long enough";
}

}  // namespace
}  // namespace steadymap

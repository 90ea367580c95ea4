#include "client/cli/text/error_line.h"

#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

TEST(ErrorLine, NamesTheServerThatCannotBeReached) {
  EXPECT_EQ(ErrorLine(absl::UnavailableError("failed to connect to all addresses; last error: no"),
                      "hall:7443"),
            "cannot reach a server at hall:7443 (no)");
  EXPECT_EQ(ErrorLine(MakeError(absl::StatusCode::kUnavailable, reason::kDraining, "going down"),
                      "hall:7443"),
            "going down [DRAINING]");
}

}  // namespace
}  // namespace steadymap

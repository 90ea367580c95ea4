#include "server/rpc/page_token.h"

#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

TEST(PageToken, ComesBackAsItsPosition) {
  for (const char* position : {"", "hall", "12345"}) {
    EXPECT_EQ(*ReadPageToken("maps", MakePageToken("maps", position)), position);
  }
}

TEST(PageToken, EmptyTokenIsTheBeginning) { EXPECT_EQ(*ReadPageToken("maps", ""), ""); }

TEST(PageToken, AnyChangedCharacterIsRefused) {
  const std::string token = MakePageToken("maps", "hall-7");
  for (std::size_t i = 0; i < token.size(); ++i) {
    std::string changed = token;
    changed[i] = changed[i] == 'A' ? 'B' : 'A';
    const auto position = ReadPageToken("maps", changed);
    EXPECT_EQ(ReasonOf(position.status()), "BAD_PAGE_TOKEN") << changed;
  }
}

TEST(PageToken, TokenOfAnotherListIsRefused) {
  EXPECT_FALSE(ReadPageToken("poses", MakePageToken("maps", "hall")).ok());
}

TEST(PageToken, PositionsThatAreNumbersComeBack) {
  EXPECT_EQ(*ReadNumberToken("events", ""), 0U);
  EXPECT_EQ(*ReadNumberToken("events", MakePageToken("events", "18446744073709551615")), ~0ULL);
  EXPECT_EQ(ReasonOf(ReadNumberToken("events", MakePageToken("events", "x")).status()),
            "BAD_PAGE_TOKEN");
  EXPECT_FALSE(ReadNumberToken("events", MakePageToken("poses", "1")).ok());
}

TEST(ListingToken, ComesBackAsItsPosition) {
  const ListingPosition first{0, 9, Revision(7)};
  const ListingPosition start = *ReadListingToken("events", "", first);
  EXPECT_EQ(start.last, 0U);
  EXPECT_EQ(start.end, 9U);
  EXPECT_EQ(start.revision, Revision(7));
  const std::string token = MakeListingToken("events", {3, 5, Revision(4)});
  const ListingPosition later = *ReadListingToken("events", token, first);
  EXPECT_EQ(later.last, 3U);
  EXPECT_EQ(later.end, 5U);
  EXPECT_EQ(later.revision, Revision(4));
  EXPECT_EQ(ReasonOf(ReadListingToken("poses", token, first).status()), "BAD_PAGE_TOKEN");
  for (const char* wrong : {"3", "3/5", "3/5/x", "3/5/4/1"}) {
    EXPECT_EQ(ReasonOf(ReadListingToken("events", MakePageToken("events", wrong), first).status()),
              "BAD_PAGE_TOKEN")
        << wrong;
  }
}

TEST(ListingToken, OfALaterRevisionThanThereIsEndsAtTheNewest) {
  const std::string token = MakeListingToken("events", {3, 50, Revision(40)});
  const ListingPosition position = *ReadListingToken("events", token, {0, 9, Revision(7)});
  EXPECT_EQ(position.last, 3U);
  EXPECT_EQ(position.end, 9U);
  EXPECT_EQ(position.revision, Revision(7));
}

TEST(PageSize, ZeroMeansTheStandard) {
  EXPECT_EQ(*ReadPageSize(0, 100, 1000), 100U);
  EXPECT_EQ(*ReadPageSize(1000, 100, 1000), 1000U);
  EXPECT_EQ(FieldOf(ReadPageSize(1001, 100, 1000).status()), "page_size");
}

}  // namespace
}  // namespace steadymap

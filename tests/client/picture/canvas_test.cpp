#include "client/picture/canvas.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "client/picture/birds_eye_legend.h"
#include "client/picture/height_ramp.h"
#include "client/picture/picture_style.h"

namespace steadymap {
namespace {

constexpr Rgb kBlack = {0, 0, 0};

TEST(Canvas, CoversPixelsByTheirShareOfABox) {
  Canvas canvas(4, 3, kWhite);
  canvas.FillBox({1.0, 0.5}, {2.5, 2.0}, kBlack);
  EXPECT_EQ(canvas.image().At(0, 1), kWhite);
  EXPECT_EQ(canvas.image().At(1, 1), kBlack);
  EXPECT_EQ(canvas.image().At(1, 0), (Rgb{127, 127, 127}));
  EXPECT_EQ(canvas.image().At(2, 1), (Rgb{127, 127, 127}));
  EXPECT_EQ(canvas.image().At(2, 0), (Rgb{191, 191, 191}));
  EXPECT_EQ(canvas.image().At(1, 2), kWhite);
}

TEST(Canvas, DrawsALineAsWideAsItsPen) {
  Canvas canvas(40, 40, kWhite);
  canvas.DrawStrokes({{{5.0, 20.0}, {35.0, 20.0}}}, 4.0, kBlack);
  double ink = 0.0;
  for (int v = 0; v < 40; ++v) ink += (255 - canvas.image().At(20, v)[0]) / 255.0;
  EXPECT_NEAR(ink, 4.0, 0.02);
}

TEST(Canvas, DoesNotDarkenWhereLinesCross) {
  Canvas canvas(20, 20, kWhite);
  const Stroke stroke = {{2.0, 10.3}, {18.0, 10.3}};
  canvas.DrawStrokes({stroke}, 1.0, kBlack);
  const Image<Rgb> once = canvas.image();
  Canvas twice(20, 20, kWhite);
  twice.DrawStrokes({stroke, stroke}, 1.0, kBlack);
  EXPECT_EQ(twice.image(), once);
}

TEST(Canvas, ClipsWhatLiesOutside) {
  Canvas canvas(8, 8, kWhite);
  canvas.DrawStrokes({{{-1e12, -1e12}, {-5.0, -9.0}}, {{20.0, 3.0}}}, 3.0, kBlack);
  canvas.FillBox({-50.0, -50.0}, {-1.0, 1e12}, kBlack);
  canvas.Write("far away", {1e9, 1e9}, 10.0, kBlack);
  canvas.DrawStrokes({}, 3.0, kBlack);
  EXPECT_EQ(canvas.image(), Image<Rgb>(8, 8, kWhite));
}

TEST(Canvas, DrawsThePartOfALongLineThatIsInThePicture) {
  Canvas canvas(21, 21, kWhite);
  canvas.DrawStrokes({{{-1e9 + 0.5, -1e9 + 10.5}, {1e9 + 0.5, 1e9 + 10.5}}}, 2.0, kBlack);
  for (int u = 0; u < 10; ++u) EXPECT_EQ(canvas.image().At(u, u + 10), kBlack) << u;
  EXPECT_EQ(canvas.image().At(10, 5), kWhite);
}

TEST(Canvas, DrawsASinglePointAsADisc) {
  Canvas canvas(21, 21, kWhite);
  canvas.FillDisc({10.5, 10.5}, 5.0, kBlack);
  const Image<Rgb> image = canvas.image();
  double ink = 0.0;
  for (int v = 0; v < 21; ++v) {
    for (int u = 0; u < 21; ++u) ink += (255 - image.At(u, v)[0]) / 255.0;
  }
  EXPECT_NEAR(ink, 25.0 * M_PI, 1.0);
}

TEST(Canvas, PastesAPictureWithinItsBounds) {
  Canvas canvas(6, 5, kWhite);
  canvas.Paste(Canvas(3, 3, kBlack), 4, 1);
  for (int v = 0; v < 5; ++v) {
    for (int u = 0; u < 6; ++u) {
      const bool is_pasted = u >= 4 && v >= 1 && v < 4;
      EXPECT_EQ(canvas.image().At(u, v), is_pasted ? kBlack : kWhite) << u << ' ' << v;
    }
  }
}

TEST(Canvas, WritesEveryPrintableCharacterWithinItsLine) {
  for (char character = '!'; character <= '~'; ++character) {
    const std::string text(1, character);
    Canvas canvas(60, 60, kWhite);
    canvas.Write(text, {20.0, 35.0}, 12.0, kBlack);
    const int end = 21 + static_cast<int>(std::ceil(TextWidth(text, 12.0)));
    const Image<Rgb> image = canvas.image();
    int dark = 0;
    for (int v = 0; v < 60; ++v) {
      for (int u = 0; u < 60; ++u) {
        if (image.At(u, v) == kWhite) continue;
        ++dark;
        EXPECT_TRUE(u >= 18 && u <= end && v >= 20 && v <= 40) << text << " at " << u << ' ' << v;
      }
    }
    EXPECT_GT(dark, 0) << text;
  }
}

TEST(Canvas, WritesCapitalsOfTheHeightAskedFor) {
  Canvas canvas(60, 60, kWhite);
  canvas.Write("H", {10.0, 50.0}, 30.0, kBlack);
  const Image<Rgb> image = canvas.image();
  for (int v = 0; v < 60; ++v) {
    bool is_inked = false;
    for (int u = 0; u < 60; ++u) is_inked = is_inked || image.At(u, v)[0] < 128;
    EXPECT_EQ(is_inked, v >= 20 && v < 50) << v;
  }
}

TEST(TextWidth, CountsOneMarkForALetterBeyondAscii) {
  EXPECT_EQ(TextWidth("a\xc3\xa9z", 10.0), TextWidth("a?z", 10.0));
  EXPECT_EQ(TextWidth("a\nz", 10.0), TextWidth("a?z", 10.0));
  EXPECT_EQ(TextWidth("", 10.0), 0.0);
}

TEST(TextWidth, ScalesWithTheHeightOfItsCapitals) {
  EXPECT_NEAR(TextWidth("steadymap", 24.0), 2.0 * TextWidth("steadymap", 12.0), 1e-6);
}

TEST(HeightColor, DarkensSteadilyAndClampsBeyondItsEnds) {
  const auto luminance = [](double share) {
    const Rgb color = HeightColor(share);
    return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2];
  };
  for (int i = 0; i < 20; ++i) EXPECT_GT(luminance(0.05 * i), luminance(0.05 * (i + 1))) << i;
  EXPECT_EQ(HeightColor(-1.0), HeightColor(0.0));
  EXPECT_EQ(HeightColor(2.0), HeightColor(1.0));
}

TEST(RoundLength, IsTheLargestRoundNumberWithinTheLimit) {
  EXPECT_DOUBLE_EQ(RoundLength(1.0), 1.0);
  EXPECT_DOUBLE_EQ(RoundLength(1.9), 1.0);
  EXPECT_DOUBLE_EQ(RoundLength(4.9), 2.0);
  EXPECT_DOUBLE_EQ(RoundLength(99.0), 50.0);
  EXPECT_DOUBLE_EQ(RoundLength(0.07), 0.05);
}

TEST(Decimal, WritesWhatAPersonWouldWrite) {
  EXPECT_EQ(Decimal(0.1 + 0.2), "0.3");
  EXPECT_EQ(Decimal(-0.0), "0");
  EXPECT_EQ(Decimal(200.0), "200");
  EXPECT_EQ(Decimal(-1.5), "-1.5");
}

TEST(Fit, CutsTextThatIsTooWide) {
  EXPECT_EQ(Fit("short", 10.0, 500.0), "short");
  const std::string cut = Fit(std::string(200, 'w'), 10.0, 100.0);
  EXPECT_LE(TextWidth(cut, 10.0), 100.0);
  EXPECT_EQ(cut.substr(cut.size() - 2), "..");
}

}  // namespace
}  // namespace steadymap

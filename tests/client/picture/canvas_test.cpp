#include "client/picture/canvas.h"

#include <string>

#include <gtest/gtest.h>

#include "client/picture/birds_eye_legend.h"
#include "client/picture/height_ramp.h"
#include "client/picture/picture_style.h"
#include "client/picture/stroke_font.h"

namespace steadymap {
namespace {

constexpr Rgb kBlack = {0, 0, 0};

TEST(Canvas, CoversPixelsByTheirShareOfABox) {
  Canvas canvas(4, 3, kWhite);
  canvas.FillBox({1.0, 0.5}, {2.5, 2.0}, kBlack);
  EXPECT_EQ(canvas.image().At(0, 1), kWhite);
  EXPECT_EQ(canvas.image().At(1, 1), kBlack);
  EXPECT_EQ(canvas.image().At(1, 0), (Rgb{128, 128, 128}));
  EXPECT_EQ(canvas.image().At(2, 1), (Rgb{128, 128, 128}));
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

TEST(StrokeFont, HasAGlyphForEveryPrintableCharacterWithinItsLine) {
  for (char character = '!'; character <= '~'; ++character) {
    const std::string text(1, character);
    const std::vector<Stroke> strokes = TextStrokes(text, {100.0, 50.0}, 12.0);
    ASSERT_FALSE(strokes.empty()) << text;
    const double right = 100.0 + TextWidth(text, 12.0);
    for (const Stroke& stroke : strokes) {
      ASSERT_FALSE(stroke.empty()) << text;
      for (const Eigen::Vector2d& point : stroke) {
        EXPECT_GE(point.x(), 100.0) << text;
        EXPECT_LE(point.x(), right) << text;
        EXPECT_GE(point.y(), 50.0 - 12.0) << text;
        EXPECT_LE(point.y(), 50.0 + 4.0) << text;
      }
    }
  }
}

TEST(StrokeFont, WritesOneMarkForALetterBeyondAscii) {
  EXPECT_EQ(TextWidth("a\xc3\xa9z", 10.0), TextWidth("a?z", 10.0));
  EXPECT_EQ(TextStrokes("\xc3\xa9", {0, 0}, 10.0), TextStrokes("?", {0, 0}, 10.0));
  EXPECT_EQ(TextWidth("", 10.0), 0.0);
}

TEST(StrokeFont, ScalesWithTheHeightOfItsCapitals) {
  EXPECT_NEAR(TextWidth("steadymap", 24.0), 2.0 * TextWidth("steadymap", 12.0), 1e-9);
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

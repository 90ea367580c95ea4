#pragma once

#include "core/frame/frame.h"

/// Colours and layout of pictures: the map's rectangle on a page, a title above it, legends to its
/// right.
namespace steadymap {

inline constexpr Rgb kPage = {247, 247, 245};
inline constexpr Rgb kWhite = {255, 255, 255};
inline constexpr Rgb kInk = {45, 48, 54};
inline constexpr Rgb kFaintInk = {105, 110, 118};
inline constexpr Rgb kFrame = {150, 154, 160};

/// Margins around the map, pixels.
inline constexpr int kLeftPx = 28;
inline constexpr int kTopPx = 84;
inline constexpr int kRightPx = 172;
inline constexpr int kBottomPx = 78;

/// Heights of capital letters, pixels.
inline constexpr double kTitlePx = 19.0;
inline constexpr double kSmallTextPx = 11.0;

/// Distance between rows of a legend, pixels.
inline constexpr double kLegendRowPx = 22.0;

}  // namespace steadymap

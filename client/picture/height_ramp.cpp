#include "client/picture/height_ramp.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Core>

namespace steadymap {
namespace {

// Oklab lightness, chroma and hue (degrees).
struct PolarColor {
  double lightness;
  double chroma;
  double hue_deg;
};

constexpr std::array<PolarColor, 5> kAnchors = {{
    {0.88, 0.045, 95.0},
    {0.76, 0.105, 155.0},
    {0.62, 0.110, 210.0},
    {0.47, 0.140, 268.0},
    {0.32, 0.150, 305.0},
}};

double GammaEncode(double linear) {
  const double clamped = std::clamp(linear, 0.0, 1.0);
  return clamped <= 0.0031308 ? 12.92 * clamped : 1.055 * std::pow(clamped, 1.0 / 2.4) - 0.055;
}

// Converts Oklab to sRGB; matrices from its definition (B. Ottosson, 2020).
Rgb ToRgb(const PolarColor& color) {
  const double hue_rad = color.hue_deg * M_PI / 180.0;
  const Eigen::Vector3d lab(
      color.lightness, color.chroma * std::cos(hue_rad), color.chroma * std::sin(hue_rad));
  Eigen::Matrix3d cone_root_from_lab;
  cone_root_from_lab << 1.0, 0.3963377774, 0.2158037573,  //
      1.0, -0.1055613458, -0.0638541728,                  //
      1.0, -0.0894841775, -1.2914855480;
  Eigen::Matrix3d rgb_from_cone;
  rgb_from_cone << 4.0767416621, -3.3077115913, 0.2309699292,  //
      -1.2684380046, 2.6097574011, -0.3413193965,              //
      -0.0041960863, -0.7034186147, 1.7076147010;
  const Eigen::Vector3d cone = (cone_root_from_lab * lab).array().cube().matrix();
  const Eigen::Vector3d linear = rgb_from_cone * cone;
  Rgb rgb;
  for (int i = 0; i < 3; ++i) {
    rgb[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::lround(255.0 * GammaEncode(linear[i])));
  }
  return rgb;
}

}  // namespace

Rgb HeightColor(double share) {
  const double position = std::clamp(share, 0.0, 1.0) * static_cast<double>(kAnchors.size() - 1);
  const auto lower = std::min(static_cast<std::size_t>(position), kAnchors.size() - 2);
  const double weight = position - static_cast<double>(lower);
  const PolarColor& from = kAnchors[lower];
  const PolarColor& to = kAnchors[lower + 1];
  return ToRgb({from.lightness + (to.lightness - from.lightness) * weight,
                from.chroma + (to.chroma - from.chroma) * weight,
                from.hue_deg + (to.hue_deg - from.hue_deg) * weight});
}

}  // namespace steadymap

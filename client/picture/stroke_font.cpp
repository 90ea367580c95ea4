#include "client/picture/stroke_font.h"

#include <array>
#include <string>

namespace steadymap {
namespace {

// Glyphs from space to tilde. Each is its width, then strokes separated by blanks; a point is a
// digit (x) and a letter (y): `a` is the lowest descender, `e` the baseline, `m` the height of
// small letters, `q` the height of capitals.
constexpr std::array<std::string_view, 95> kGlyphs = {
    "3",                                      // space
    "2 1q1i 1f1e",                            // !
    "3 0q0n 2q2n",                            // "
    "6 2q1e 5q4e 0m6m 0i6i",                  // #
    "6 6o4q2q0o0m2k4k6i6g4e2e0g 3q3e",        // $
    "6 0e6q 1q2p1n0p1q 5h6g5e4g5h",           // %
    "6 6e1n1p2q3q4p4n0i0g2e3e6i",             // &
    "2 1q1n",                                 // '
    "2 2q0n0g2d",                             // (
    "2 0q2n2g0d",                             // )
    "6 3p3j 0n6l 0l6n",                       // *
    "6 0j6j 3m3g",                            // +
    "2 1f0c",                                 // ,
    "4 0j4j",                                 // -
    "2 1f1e",                                 // .
    "5 0d5q",                                 // /
    "6 2q4q6o6g4e2e0g0o2q",                   // 0
    "4 0n3q3e",                               // 1
    "6 0o2q4q6o6m0e6e",                       // 2
    "6 0o2q4q6o6m4k2k 4k6i6g4e2e0g",          // 3
    "6 5e5q0h6h",                             // 4
    "6 6q1q0k2l4l6j6g4e2e0g",                 // 5
    "6 5q3q1o0k0g2e4e6g6i4k2k0i",             // 6
    "6 0q6q2e",                               // 7
    "6 2q4q6o6m4k2k0m0o2q 2k0i0g2e4e6g6i4k",  // 8
    "6 6k4i2i0k0o2q4q6o6k5g3e1e",             // 9
    "2 1f1e 1m1l",                            // :
    "2 1f0c 1m1l",                            // ;
    "5 5m0j5g",                               // <
    "6 0l6l 0h6h",                            // =
    "5 0m5j0g",                               // >
    "6 0o2q4q6o6m3j3h 3f3e",                  // ?
    "7 5m3m2l2j3i5i5m5j6i7j7n5q2q0o0g2e6e",   // @
    "6 0e3q6e 1i5i",                          // A
    "6 0e0q4q6o6m4k0k 4k6i6g4e0e",            // B
    "7 7o5q2q0o0g2e5e7g",                     // C
    "7 0e0q4q7n7h4e0e",                       // D
    "6 6q0q0e6e 0k5k",                        // E
    "6 6q0q0e 0k5k",                          // F
    "7 7o5q2q0o0g2e5e7g7k4k",                 // G
    "7 0q0e 7q7e 0k7k",                       // H
    "2 1q1e",                                 // I
    "5 5q5g3e2e0g",                           // J
    "6 0q0e 6q0i 2l6e",                       // K
    "6 0q0e6e",                               // L
    "8 0e0q4i8q8e",                           // M
    "7 0e0q7e7q",                             // N
    "7 2q5q7o7g5e2e0g0o2q",                   // O
    "6 0e0q4q6o6l4j0j",                       // P
    "7 2q5q7o7g5e2e0g0o2q 4h7d",              // Q
    "6 0e0q4q6o6l4j0j 3j6e",                  // R
    "6 6o4q2q0o0m2k4k6i6g4e2e0g",             // S
    "6 3q3e 0q6q",                            // T
    "7 0q0g2e5e7g7q",                         // U
    "6 0q3e6q",                               // V
    "8 0q2e4o6e8q",                           // W
    "6 0q6e 0e6q",                            // X
    "6 0q3k6q 3k3e",                          // Y
    "6 0q6q0e6e",                             // Z
    "2 2q0q0d2d",                             // [
    "5 0q5d",                                 // backslash
    "2 0q2q2d0d",                             // ]
    "6 0m3q6m",                               // ^
    "6 0d6d",                                 // _
    "2 0q1n",                                 // `
    "6 6m6e 6k4m2m0k0g2e4e6g",                // a
    "6 0q0e 0k2m4m6k6g4e2e0g",                // b
    "6 6k4m2m0k0g2e4e6g",                     // c
    "6 6q6e 6k4m2m0k0g2e4e6g",                // d
    "6 0i6i6k4m2m0k0g2e4e6f",                 // e
    "4 4q3q2o2e 0m4m",                        // f
    "6 6m6c4a2a0b 6k4m2m0k0g2e4e6g",          // g
    "6 0q0e 0k2m4m6k6e",                      // h
    "2 1m1e 1q1p",                            // i
    "3 2m2b1a0a 2q2p",                        // j
    "5 0q0e 5m0h 2j5e",                       // k
    "2 1q1e",                                 // l
    "8 0m0e 0k2m3m4k4e 4k6m7m8k8e",           // m
    "6 0m0e 0k2m4m6k6e",                      // n
    "6 2m4m6k6g4e2e0g0k2m",                   // o
    "6 0m0a 0k2m4m6k6g4e2e0g",                // p
    "6 6m6a 6k4m2m0k0g2e4e6g",                // q
    "4 0m0e 0k2m4m",                          // r
    "5 5l4m1m0l0j1i4i5h5f4e1e0f",             // s
    "4 2q2f3e4e 0m4m",                        // t
    "6 0m0g2e4e6g 6m6e",                      // u
    "6 0m3e6m",                               // v
    "8 0m2e4l6e8m",                           // w
    "5 0m5e 0e5m",                            // x
    "6 0m3e 6m2b1a0a",                        // y
    "5 0m5m0e5e",                             // z
    "3 3q2p2l0j2h2e3d",                       // {
    "2 1q1d",                                 // |
    "3 0q1p1l3j1h1e0d",                       // }
    "6 0j2k4i6j",                             // ~
};

constexpr double kCapHeight = 'q' - 'e';
constexpr double kSpacing = 3.0;

std::string_view GlyphOf(char character) {
  if (character < ' ' || character > '~') character = '?';
  return kGlyphs[static_cast<std::size_t>(character - ' ')];
}

double WidthOf(std::string_view glyph) { return glyph.front() - '0'; }

// Replaces each run of bytes beyond ASCII, such as a UTF-8 letter, by its first byte.
std::string Printable(std::string_view text) {
  std::string printable;
  bool in_run = false;
  for (const char character : text) {
    const bool beyond_ascii = static_cast<unsigned char>(character) > 127;
    if (!(beyond_ascii && in_run)) printable += character;
    in_run = beyond_ascii;
  }
  return printable;
}

}  // namespace

std::vector<Stroke> TextStrokes(std::string_view text,
                                const Eigen::Vector2d& origin_px,
                                double cap_height_px) {
  const double scale_px = cap_height_px / kCapHeight;
  std::vector<Stroke> strokes;
  Eigen::Vector2d pen_px = origin_px;
  for (const char character : Printable(text)) {
    const std::string_view glyph = GlyphOf(character);
    for (std::size_t i = 1; i < glyph.size();) {
      if (glyph[i] == ' ') {
        strokes.emplace_back();
        ++i;
        continue;
      }
      const Eigen::Vector2d point(glyph[i] - '0', 'e' - glyph[i + 1]);
      strokes.back().push_back(pen_px + point * scale_px);
      i += 2;
    }
    pen_px.x() += (WidthOf(glyph) + kSpacing) * scale_px;
  }
  return strokes;
}

double TextWidth(std::string_view text, double cap_height_px) {
  const std::string printable = Printable(text);
  if (printable.empty()) return 0.0;
  double width = -kSpacing;
  for (const char character : printable) width += WidthOf(GlyphOf(character)) + kSpacing;
  return width * cap_height_px / kCapHeight;
}

}  // namespace steadymap

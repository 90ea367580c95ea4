#pragma once

#include <array>
#include <csetjmp>
#include <cstring>

#include <png.h>

#include "core/frame/error_jump.h"

namespace steadymap {

/// Where libpng's errors go; calls into libpng stand inside `Guard`.
struct PngErrorTrap {
  std::jmp_buf jump;
  std::array<char, 128> message{};  ///< What the error was, cut to this length.
};

/// libpng's error callback: its pointer is a `PngErrorTrap`.
[[noreturn]] inline void OnPngError(png_structp png, png_const_charp message) {
  auto* trap = static_cast<PngErrorTrap*>(png_get_error_ptr(png));
  std::strncpy(trap->message.data(), message, trap->message.size() - 1);
  std::longjmp(trap->jump, 1);
}

/// libpng's warning callback: what is only a warning is none of ours.
inline void OnPngWarning(png_structp, png_const_charp) {}

}  // namespace steadymap

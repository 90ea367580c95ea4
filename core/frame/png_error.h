#pragma once

#include <array>
#include <csetjmp>
#include <cstring>

#include <png.h>

#include "core/frame/error_jump.h"

namespace steadymap {

/// The target of libpng's error callbacks. All calls into libpng run inside `Guard`.
struct PngErrorTrap {
  std::jmp_buf jump;
  std::array<char, 128> message{};  ///< The error message, truncated to this length.
};

/// The error callback of libpng; its pointer is a `PngErrorTrap`.
[[noreturn]] inline void OnPngError(png_structp png, png_const_charp message) {
  auto* trap = static_cast<PngErrorTrap*>(png_get_error_ptr(png));
  std::strncpy(trap->message.data(), message, trap->message.size() - 1);
  std::longjmp(trap->jump, 1);
}

/// The warning callback of libpng. Ignores warnings.
inline void OnPngWarning(png_structp, png_const_charp) {}

}  // namespace steadymap

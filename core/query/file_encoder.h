#pragma once

#include <cstddef>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// Maximum length of a piece from a `FileEncoder`: a few milliseconds of work, after which other
/// calls can run.
inline constexpr std::size_t kFilePieceBytes = std::size_t{1} << 18;

/// Produces a file in pieces, so that the caller never holds it as a whole. Not thread-safe.
class FileEncoder {
 public:
  virtual ~FileEncoder() = default;

  /// Replaces the content of `piece` by the next piece of the file, 1 to `kFilePieceBytes` bytes.
  /// At the end of the file returns false with an empty piece. Not to be called after an error.
  virtual absl::StatusOr<bool> Next(std::string* piece) = 0;
};

/// Returns the status of a cancelled encoder.
absl::Status CancelledFileError();

/// Returns the remaining file as a whole, for small files. Errors: of the encoder.
absl::StatusOr<std::string> EncodeWhole(FileEncoder* encoder);

}  // namespace steadymap

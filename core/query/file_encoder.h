#pragma once

#include <cstddef>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// The longest piece that a `FileEncoder` makes: some milliseconds of work, after which others have
/// their turn.
inline constexpr std::size_t kFilePieceBytes = std::size_t{1} << 18;

/// Makes a file piece by piece, so that nobody has to hold it whole. Not thread-safe.
class FileEncoder {
 public:
  virtual ~FileEncoder() = default;

  /// Puts the next piece of the file, 1 to `kFilePieceBytes` bytes, in place of what `piece` holds.
  /// False, and `piece` is empty, once the file is whole. After an error nothing more comes.
  virtual absl::StatusOr<bool> Next(std::string* piece) = 0;
};

/// What an encoder that was cancelled answers.
absl::Status CancelledFileError();

/// The rest of a file, whole: for files that are known to be small. Errors: those of the encoder.
absl::StatusOr<std::string> EncodeWhole(FileEncoder* encoder);

}  // namespace steadymap

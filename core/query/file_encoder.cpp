#include "core/query/file_encoder.h"

namespace steadymap {

absl::Status CancelledFileError() { return absl::CancelledError("the export was cancelled"); }

absl::StatusOr<std::string> EncodeWhole(FileEncoder* encoder) {
  std::string file;
  std::string piece;
  while (true) {
    const absl::StatusOr<bool> more = encoder->Next(&piece);
    if (!more.ok()) return more.status();
    if (!*more) return file;
    file += piece;
  }
}

}  // namespace steadymap

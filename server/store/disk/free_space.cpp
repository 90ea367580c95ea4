#include "server/store/disk/free_space.h"

#include <absl/strings/str_cat.h>

#include "core/types/error.h"

namespace steadymap {

absl::Status CheckFreeSpace(const absl::StatusOr<std::uint64_t>& free_bytes,
                            std::uint64_t min_bytes) {
  if (!free_bytes.ok()) return free_bytes.status();
  if (*free_bytes >= min_bytes) return absl::OkStatus();
  return MakeError(absl::StatusCode::kResourceExhausted,
                   reason::kDiskLow,
                   absl::StrCat("the disk of the data folder has ",
                                *free_bytes,
                                " bytes left, fewer than the ",
                                min_bytes,
                                " that are kept free"));
}

}  // namespace steadymap

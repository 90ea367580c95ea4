#pragma once

#include <cstdint>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// Returns OK if `free_bytes`, the free space of the data folder's disk, is at least `min_bytes`.
/// Errors: `ResourceExhausted` with reason `DISK_LOW`; the error of `free_bytes`.
absl::Status CheckFreeSpace(const absl::StatusOr<std::uint64_t>& free_bytes,
                            std::uint64_t min_bytes);

}  // namespace steadymap

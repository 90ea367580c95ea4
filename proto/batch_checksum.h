#pragma once

#include <cstdint>

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {

/// The correct value of `images_crc32c`: the CRC-32C of the `data` bytes of all images of all
/// frames, frame by frame, in the order depth, labels, instances, color. Any thread.
std::uint32_t ImagesCrc32c(const v1::FrameBatch& batch);

}  // namespace steadymap

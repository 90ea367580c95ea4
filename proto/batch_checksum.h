#pragma once

#include <cstdint>

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {

/// What `images_crc32c` of the batch must hold: the CRC-32C over the `data` of all images of all
/// frames, in the order depth, labels, instances, color within each frame. Any thread.
std::uint32_t ImagesCrc32c(const v1::FrameBatch& batch);

}  // namespace steadymap

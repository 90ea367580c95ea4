#include "proto/batch_checksum.h"

#include "core/types/crc32c.h"

namespace steadymap {

std::uint32_t ImagesCrc32c(const v1::FrameBatch& batch) {
  std::uint32_t crc = 0;
  for (const v1::Frame& frame : batch.frames()) {
    crc = ExtendCrc32c(crc, frame.depth().data());
    crc = ExtendCrc32c(crc, frame.labels().data());
    crc = ExtendCrc32c(crc, frame.instances().data());
    crc = ExtendCrc32c(crc, frame.color().data());
  }
  return crc;
}

}  // namespace steadymap

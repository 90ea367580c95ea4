#pragma once

#include <cstddef>

#include <absl/status/status.h>
#include <google/protobuf/message.h>
#include <grpcpp/support/byte_buffer.h>

namespace steadymap {

/// What a serialized request may hold at most.
struct RequestLimits {
  std::size_t max_bytes = 0;
  /// Fields, those of nested messages included: what bounds the memory of the parsed request, since
  /// an empty message takes two bytes on the wire and some dozens in memory.
  std::size_t max_fields = 0;
};

/// For requests that hold no images and no lists of points. A class table of the greatest size
/// fits.
inline constexpr RequestLimits kPlainRequestLimits{.max_bytes = std::size_t{1} << 20,
                                                   .max_fields = 32'768};

/// For requests with up to 100 000 points or rays: a ray is 9 fields and 60 bytes.
inline constexpr RequestLimits kPointRequestLimits{.max_bytes = std::size_t{8} << 20,
                                                   .max_fields = 1'000'000};

/// Parses a request into `message`, without the fields that this version does not know. Checks the
/// limits before anything is allocated. Errors: `ResourceExhausted` with reason
/// `MESSAGE_TOO_LARGE`; `InvalidArgument` with reason `BAD_MESSAGE` for bytes that are no such
/// message.
absl::Status ReadRequest(const grpc::ByteBuffer& bytes,
                         const RequestLimits& limits,
                         google::protobuf::Message* message);

/// A message as it goes to gRPC. Copies share the bytes.
grpc::ByteBuffer ToByteBuffer(const google::protobuf::Message& message);

}  // namespace steadymap

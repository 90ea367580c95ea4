#pragma once

#include <cstddef>

#include <absl/status/status.h>
#include <google/protobuf/message.h>
#include <grpcpp/support/byte_buffer.h>

namespace steadymap {

/// Limits on the size of a serialized request.
struct RequestLimits {
  std::size_t max_bytes = 0;
  /// Number of fields, including those of nested messages. Bounds the memory of the parsed request,
  /// because an empty message uses two bytes on the wire but several dozen bytes in memory.
  std::size_t max_fields = 0;
};

/// Limits for requests without images or lists of points. A class table of maximum size fits.
inline constexpr RequestLimits kPlainRequestLimits{.max_bytes = std::size_t{1} << 20,
                                                   .max_fields = 32'768};

/// Limits for requests with up to 100 000 points or rays; a ray has 9 fields and 60 bytes.
inline constexpr RequestLimits kPointRequestLimits{.max_bytes = std::size_t{8} << 20,
                                                   .max_fields = 1'000'000};

/// Parses a request into `message` and drops unknown fields. Checks the limits before any memory is
/// allocated. Errors: `ResourceExhausted` with reason `MESSAGE_TOO_LARGE`; `InvalidArgument` with
/// reason `BAD_MESSAGE` for bytes that are not a message of this type.
absl::Status ReadRequest(const grpc::ByteBuffer& bytes,
                         const RequestLimits& limits,
                         google::protobuf::Message* message);

/// Serializes a message for gRPC. Copies of the buffer share the bytes.
grpc::ByteBuffer ToByteBuffer(const google::protobuf::Message& message);

}  // namespace steadymap

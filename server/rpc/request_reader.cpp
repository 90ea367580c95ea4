#include "server/rpc/request_reader.h"

#include <absl/strings/str_cat.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>
#include <grpcpp/impl/codegen/proto_utils.h>
#include <grpcpp/support/proto_buffer_reader.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

/// Counts the fields of a serialized message without allocating any, and checks whether the type
/// contains all of them.
class FieldCount {
 public:
  FieldCount(CodedInputStream* input, std::size_t max_fields) : input_(input), left_(max_fields) {}

  /// Returns false if the bytes are not a valid message, or contain too many fields.
  bool Visit(const Descriptor& type) {
    while (const std::uint32_t tag = input_->ReadTag()) {
      if (left_ == 0) {
        has_too_many_ = true;
        return false;
      }
      --left_;
      if (!VisitValue(type, tag)) return false;
    }
    return input_->ConsumedEntireMessage();
  }

  bool has_too_many() const { return has_too_many_; }

  bool has_unknown() const { return has_unknown_; }

 private:
  bool VisitValue(const Descriptor& type, std::uint32_t tag) {
    const FieldDescriptor* field = type.FindFieldByNumber(WireFormatLite::GetTagFieldNumber(tag));
    if (field == nullptr || !IsTypeOf(*field, WireFormatLite::GetTagWireType(tag))) {
      has_unknown_ = true;
    }
    const bool is_message = field != nullptr && field->type() == FieldDescriptor::TYPE_MESSAGE;
    switch (WireFormatLite::GetTagWireType(tag)) {
      case WireFormatLite::WIRETYPE_VARINT: {
        std::uint64_t value = 0;
        return input_->ReadVarint64(&value);
      }
      case WireFormatLite::WIRETYPE_FIXED64:
        return input_->Skip(8);
      case WireFormatLite::WIRETYPE_FIXED32:
        return input_->Skip(4);
      case WireFormatLite::WIRETYPE_LENGTH_DELIMITED:
        return VisitBytes(is_message ? field->message_type() : nullptr);
      default:
        // Groups: no message of the API uses them.
        return false;
    }
  }

  /// True if a parser accepts the wire type `written` for the field, and does not store the value
  /// as an unknown field.
  static bool IsTypeOf(const FieldDescriptor& field, WireFormatLite::WireType written) {
    const auto type = static_cast<WireFormatLite::FieldType>(field.type());
    return written == WireFormatLite::WireTypeForFieldType(type) ||
           (field.is_packable() && written == WireFormatLite::WIRETYPE_LENGTH_DELIMITED);
  }

  /// Visits a string, packed numbers or an unknown field if `type` is null, else a message of
  /// `type`.
  bool VisitBytes(const Descriptor* type) {
    std::uint32_t length = 0;
    if (!input_->ReadVarint32(&length) || length > INT32_MAX) return false;
    const auto size = static_cast<int>(length);
    if (type == nullptr) return input_->Skip(size);
    const auto [limit, depth_left] = input_->IncrementRecursionDepthAndPushLimit(size);
    return depth_left >= 0 && Visit(*type) && input_->DecrementRecursionDepthAndPopLimit(limit);
  }

  CodedInputStream* const input_;
  std::size_t left_;
  bool has_too_many_ = false;
  bool has_unknown_ = false;
};

absl::Status TooLarge(const char* what, std::size_t limit) {
  return MakeError(absl::StatusCode::kResourceExhausted,
                   reason::kMessageTooLarge,
                   absl::StrCat("the message has more than the ", limit, " ", what, " allowed"));
}

}  // namespace

absl::Status ReadRequest(const grpc::ByteBuffer& bytes,
                         const RequestLimits& limits,
                         google::protobuf::Message* message) {
  if (bytes.Length() > limits.max_bytes) return TooLarge("bytes", limits.max_bytes);
  message->Clear();
  // gRPC cannot read a buffer without slices.
  if (bytes.Length() == 0) return absl::OkStatus();
  absl::Status bad_message =
      MakeError(absl::StatusCode::kInvalidArgument,
                reason::kBadMessage,
                absl::StrCat("the bytes are not a valid ", message->GetDescriptor()->full_name()));
  grpc::ByteBuffer copy(bytes);  // Shares the bytes.
  bool has_unknown = false;
  {
    grpc::ProtoBufferReader reader(&copy);
    CodedInputStream input(&reader);
    FieldCount fields(&input, limits.max_fields);
    if (!reader.status().ok()) return bad_message;
    if (!fields.Visit(*message->GetDescriptor())) {
      return fields.has_too_many() ? TooLarge("fields", limits.max_fields) : bad_message;
    }
    has_unknown = fields.has_unknown();
  }
  grpc::ProtoBufferReader reader(&copy);
  if (!message->ParseFromZeroCopyStream(&reader)) return bad_message;
  // A message keeps its unknown fields in memory. The search for them costs more than the parsing,
  // so it is done only if there are any.
  if (has_unknown) message->DiscardUnknownFields();
  return absl::OkStatus();
}

grpc::ByteBuffer ToByteBuffer(const google::protobuf::Message& message) {
  grpc::ByteBuffer bytes;
  bool owned = false;
  // Fails only for messages above 2 GiB.
  const grpc::Status status =
      grpc::GenericSerialize<grpc::ProtoBufferWriter, google::protobuf::Message>(
          message, &bytes, &owned);
  return status.ok() ? bytes : grpc::ByteBuffer();
}

}  // namespace steadymap

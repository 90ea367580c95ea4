// Tests invalid requests, sent to every RPC of every service in proto/steadymap/v1: a new RPC is
// covered as soon as its service is registered.

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include "tests/contract/test_service.h"

namespace steadymap {
namespace {

using absl::StatusCode;
using MessageType = google::protobuf::Descriptor;
using google::protobuf::DescriptorPool;
using google::protobuf::FieldDescriptor;
using google::protobuf::MethodDescriptor;
using google::protobuf::internal::WireFormatLite;

/// Returns all RPCs, by full name.
std::vector<const MethodDescriptor*> AllMethods() {
  std::vector<const MethodDescriptor*> methods;
  const std::string folder = STEADYMAP_PROTO_DIR;
  for (const auto& entry : std::filesystem::directory_iterator(folder + "/steadymap/v1")) {
    const auto* file = DescriptorPool::generated_pool()->FindFileByName(
        "steadymap/v1/" + entry.path().filename().string());
    EXPECT_NE(file, nullptr) << entry.path();
    if (file == nullptr) continue;
    for (int i = 0; i < file->service_count(); ++i) {
      for (int k = 0; k < file->service(i)->method_count(); ++k) {
        methods.push_back(file->service(i)->method(k));
      }
    }
  }
  std::sort(methods.begin(), methods.end(), [](const auto* a, const auto* b) {
    return a->full_name() < b->full_name();
  });
  return methods;
}

/// Sends one message to an RPC of any kind, reads the responses, and returns the final status.
absl::Status Send(TestService* service, const MethodDescriptor& method, const std::string& bytes) {
  grpc::ClientContext context;
  SetDeadline(&context);
  grpc::CompletionQueue queue;
  const auto await = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  grpc::GenericStub stub(service->channel());
  const auto call =
      stub.PrepareCall(&context, "/" + method.service()->full_name() + "/" + method.name(), &queue);
  call->StartCall(nullptr);
  grpc::Status status;
  if (await()) {
    const grpc::Slice slice(bytes);
    call->WriteLast(grpc::ByteBuffer(&slice, 1), grpc::WriteOptions(), nullptr);
    // A call that is refused early may not read the whole message.
    await();
    grpc::ByteBuffer response;
    do {
      call->Read(&response, nullptr);
    } while (await());
  }
  call->Finish(&status, nullptr);
  EXPECT_TRUE(await());
  return FromGrpcStatus(status);
}

/// Returns a field of a message with its tag and length.
std::string Bytes(int field_number, const std::string& value) {
  std::string bytes;
  {
    google::protobuf::io::StringOutputStream stream(&bytes);
    google::protobuf::io::CodedOutputStream output(&stream);
    output.WriteTag(
        WireFormatLite::MakeTag(field_number, WireFormatLite::WIRETYPE_LENGTH_DELIMITED));
    output.WriteVarint32(static_cast<std::uint32_t>(value.size()));
  }
  return bytes + value;
}

/// Returns the field numbers of the path to a field for which `wanted` is true, outermost first;
/// none if there is no such field within a few levels.
std::optional<std::vector<int>> FindPath(const MessageType& type,
                                         const std::function<bool(const FieldDescriptor&)>& wanted,
                                         int levels = 4) {
  for (int i = 0; i < type.field_count(); ++i) {
    if (wanted(*type.field(i))) return std::vector<int>{type.field(i)->number()};
  }
  for (int i = 0; i < type.field_count() && levels > 0; ++i) {
    const FieldDescriptor& field = *type.field(i);
    if (field.type() != FieldDescriptor::TYPE_MESSAGE) continue;
    if (auto path = FindPath(*field.message_type(), wanted, levels - 1)) {
      path->insert(path->begin(), field.number());
      return path;
    }
  }
  return std::nullopt;
}

/// Returns a message with `count` copies of `value` in the field at the end of `path`.
std::string Nested(std::vector<int> path, const std::string& value, std::size_t count = 1) {
  const std::string one = Bytes(path.back(), value);
  path.pop_back();
  std::string bytes;
  for (std::size_t i = 0; i < count; ++i) bytes += one;
  for (; !path.empty(); path.pop_back()) bytes = Bytes(path.back(), bytes);
  return bytes;
}

/// Unused in our messages.
constexpr int kUnknownField = 12'345;

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

/// Returns the size limit of an RPC. The exceptions are documented at its service.
std::size_t MaxBytes(const MethodDescriptor& method) {
  static const std::map<std::string, std::size_t> exceptions = {
      {"UploadFrames", 8 * kMebibyte},
      {"UploadFrameBatch", 8 * kMebibyte},
      {"SampleDistance", 8 * kMebibyte},
      {"CastRays", 8 * kMebibyte},
  };
  const auto found = exceptions.find(method.name());
  return found == exceptions.end() ? kMebibyte : found->second;
}

class HostileRequest : public ::testing::Test {
 protected:
  /// Sends to each RPC the message from `make`, and passes the status to `check`.
  void ForEachMethod(
      const std::function<std::string(const MethodDescriptor&)>& make,
      const std::function<void(const MethodDescriptor&, const absl::Status&)>& check) {
    ASSERT_GE(methods_.size(), 17U);
    for (const MethodDescriptor* method : methods_) {
      SCOPED_TRACE(method->full_name());
      check(*method, Send(&service_, *method, make(*method)));
    }
    // The server still works.
    EXPECT_FALSE(service_.CreateMap("hall").empty());
  }

  TestService service_{Transport::kLoopback};
  const std::vector<const MethodDescriptor*> methods_ = AllMethods();
};

void ExpectBadMessage(const MethodDescriptor& method, const absl::Status& status) {
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << status;
  EXPECT_EQ(ReasonOf(status), reason::kBadMessage);
  EXPECT_NE(status.message().find(method.input_type()->full_name()), absl::string_view::npos)
      << status;
}

void ExpectTooLarge(const MethodDescriptor& /*method*/, const absl::Status& status) {
  EXPECT_EQ(status.code(), StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(ReasonOf(status), reason::kMessageTooLarge) << status;
}

TEST_F(HostileRequest, GarbageIsNoMessage) {
  ForEachMethod([](const auto&) { return std::string(20, '\xFF'); }, ExpectBadMessage);
}

TEST_F(HostileRequest, CutOffMessageIsNoMessage) {
  ForEachMethod(
      [](const auto&) {
        const std::string whole = Bytes(kUnknownField, "abc");
        return whole.substr(0, whole.size() - 1);
      },
      ExpectBadMessage);
}

TEST_F(HostileRequest, TextThatIsNotUtf8IsRefused) {
  ForEachMethod(
      [](const MethodDescriptor& method) {
        const auto path = FindPath(*method.input_type(), [](const FieldDescriptor& field) {
          return field.type() == FieldDescriptor::TYPE_STRING;
        });
        EXPECT_TRUE(path.has_value()) << "no text in any field of the request";
        return path ? Nested(*path, "ha\xC3(l") : std::string();
      },
      ExpectBadMessage);
}

/// Returns a message of this size without known fields.
std::string MessageOfSize(std::size_t size) {
  // Tag and length take some bytes, more for the first, long text.
  const std::string most = Bytes(kUnknownField, std::string(size - 100, 'x'));
  const std::size_t header = Bytes(kUnknownField, "").size();
  return most + Bytes(kUnknownField, std::string(size - most.size() - header, 'x'));
}

TEST_F(HostileRequest, AsManyBytesAsTheLimitAreRead) {
  ForEachMethod([](const auto& method) { return MessageOfSize(MaxBytes(method)); },
                [](const auto&, const absl::Status& status) {
                  EXPECT_FALSE(status.ok());
                  EXPECT_NE(ReasonOf(status), reason::kMessageTooLarge) << status;
                });
}

TEST_F(HostileRequest, AByteMoreIsTooLarge) {
  ForEachMethod([](const auto& method) { return MessageOfSize(MaxBytes(method) + 1); },
                ExpectTooLarge);
}

TEST_F(HostileRequest, AMillionEmptyMessagesAreTooLarge) {
  ForEachMethod(
      [](const MethodDescriptor& method) {
        const auto path = FindPath(*method.input_type(), [](const FieldDescriptor& field) {
          return field.is_repeated() && field.type() == FieldDescriptor::TYPE_MESSAGE;
        });
        // Without a repeated message, an unknown field is repeated.
        const std::vector<int> repeated = path.value_or(std::vector<int>{kUnknownField});
        const std::size_t size = Bytes(repeated.back(), "").size();
        return Nested(repeated, "", (MaxBytes(method) - 100) / size);
      },
      ExpectTooLarge);
}

TEST_F(HostileRequest, FieldsThatAreNotKnownChangeNothing) {
  std::map<std::string, absl::Status> plain;
  ForEachMethod([](const auto&) { return std::string(); },
                [&](const MethodDescriptor& method, const absl::Status& status) {
                  EXPECT_FALSE(status.ok());
                  plain[method.full_name()] = status;
                });
  for (const MethodDescriptor* method : methods_) {
    SCOPED_TRACE(method->full_name());
    EXPECT_EQ(Send(&service_, *method, Bytes(kUnknownField, "of a later version")),
              plain[method->full_name()]);
  }
}

}  // namespace
}  // namespace steadymap

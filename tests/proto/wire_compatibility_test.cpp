#include <cstdlib>
#include <fstream>
#include <set>
#include <string>

#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include "steadymap/v1/ingest_service.pb.h"
#include "steadymap/v1/map_service.pb.h"
#include "steadymap/v1/query_service.pb.h"
#include "steadymap/v1/watch_service.pb.h"

// After version 1 of the protocol is frozen, clients and servers of any age must be compatible: no
// element on the wire may change or be removed. The frozen elements are listed in
// proto/steadymap/v1.frozen, one line per field, value and call. The following command writes the
// file:
//
//   STEADYMAP_FREEZE=1 build/dev/tests/proto/convert_test --gtest_filter='WireCompatibility.*'
//
// Without this file nothing is frozen.
namespace steadymap {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;
using google::protobuf::MethodDescriptor;

const char* const kFrozenFile = STEADYMAP_SOURCE_DIR "/proto/steadymap/v1.frozen";

/// The elements that affect the wire format or JSON, of a file and of the project files that it
/// imports, one line per element.
class WireSurface {
 public:
  void AddFile(const FileDescriptor& file) {
    if (file.package() != "steadymap.v1" || !files_.insert(file.name()).second) return;
    for (int i = 0; i < file.dependency_count(); ++i) AddFile(*file.dependency(i));
    for (int i = 0; i < file.message_type_count(); ++i) AddMessage(*file.message_type(i));
    for (int i = 0; i < file.enum_type_count(); ++i) AddEnum(*file.enum_type(i));
    for (int i = 0; i < file.service_count(); ++i) {
      for (int j = 0; j < file.service(i)->method_count(); ++j) {
        AddMethod(*file.service(i)->method(j));
      }
    }
  }

  const std::set<std::string>& lines() const { return lines_; }

 private:
  void AddMessage(const Descriptor& message) {
    for (int i = 0; i < message.field_count(); ++i) AddField(*message.field(i));
    for (int i = 0; i < message.nested_type_count(); ++i) AddMessage(*message.nested_type(i));
    for (int i = 0; i < message.enum_type_count(); ++i) AddEnum(*message.enum_type(i));
  }

  void AddField(const FieldDescriptor& field) {
    std::string line = field.full_name() + " = " + std::to_string(field.number()) + " " +
                       (field.is_repeated() ? "repeated " : "") +
                       (field.has_presence() ? "present " : "") + field.type_name();
    if (field.message_type() != nullptr) line += " " + field.message_type()->full_name();
    if (field.enum_type() != nullptr) line += " " + field.enum_type()->full_name();
    if (field.real_containing_oneof() != nullptr) {
      line += " of " + field.real_containing_oneof()->name();
    }
    lines_.insert(line);
  }

  void AddEnum(const EnumDescriptor& type) {
    for (int i = 0; i < type.value_count(); ++i) {
      lines_.insert(type.full_name() + "." + type.value(i)->name() + " = " +
                    std::to_string(type.value(i)->number()));
    }
  }

  void AddMethod(const MethodDescriptor& method) {
    lines_.insert("rpc " + method.full_name() + (method.client_streaming() ? " stream " : " ") +
                  method.input_type()->full_name() +
                  (method.server_streaming() ? " returns stream " : " returns ") +
                  method.output_type()->full_name());
  }

  std::set<std::string> files_;
  std::set<std::string> lines_;
};

WireSurface Surface() {
  WireSurface surface;
  surface.AddFile(*v1::CreateMapRequest::descriptor()->file());
  surface.AddFile(*v1::UploadOpen::descriptor()->file());
  surface.AddFile(*v1::ListObjectsRequest::descriptor()->file());
  surface.AddFile(*v1::WatchMapRequest::descriptor()->file());
  return surface;
}

TEST(WireCompatibility, TheSurfaceIsThatOfEveryFile) {
  const std::set<std::string> lines = Surface().lines();
  EXPECT_TRUE(lines.contains("steadymap.v1.Map.name = 1 string"));
  EXPECT_TRUE(
      lines.contains("steadymap.v1.Frame.depth = 4 present message steadymap.v1.DepthImage"));
  EXPECT_TRUE(lines.contains("steadymap.v1.AckLevel.ACK_LEVEL_DURABLE = 2"));
  EXPECT_TRUE(lines.contains(
      "rpc steadymap.v1.WatchService.WatchMap steadymap.v1.WatchMapRequest returns stream "
      "steadymap.v1.WatchMapResponse"));
}

TEST(WireCompatibility, NothingThatIsFrozenHasChanged) {
  const std::set<std::string> lines = Surface().lines();
  // NOLINTNEXTLINE(concurrency-mt-unsafe): no thread writes the environment.
  if (std::getenv("STEADYMAP_FREEZE") != nullptr) {
    std::ofstream file(kFrozenFile);
    for (const std::string& line : lines) file << line << "\n";
    ASSERT_TRUE(file.flush());
  }
  std::ifstream file(kFrozenFile);
  for (std::string line; std::getline(file, line);) {
    EXPECT_TRUE(lines.contains(line)) << "clients that were built before rely on: " << line;
  }
}

}  // namespace
}  // namespace steadymap

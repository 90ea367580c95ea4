#pragma once

#include <functional>
#include <memory>
#include <string>

#include <absl/status/status.h>
#include <gmock/gmock.h>
#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include "core/types/error.h"
#include "proto/grpc_status.h"
#include "server/server.h"
#include "tests/support/memory_store.h"

#include "steadymap/v1/ingest_service.grpc.pb.h"
#include "steadymap/v1/map_service.grpc.pb.h"
#include "steadymap/v1/query_service.grpc.pb.h"

namespace steadymap {

/// Transport between client and server; the contract is identical.
enum class Transport { kInProcess, kLoopback };

/// Names the parameter of a suite in the test output.
std::string TransportName(const ::testing::TestParamInfo<Transport>& info);

/// A server with a client's stubs. By default it uses a memory store that the test can make fail.
class TestService {
 public:
  /// `adjust` changes the configuration.
  explicit TestService(Transport transport, const std::function<void(ServerConfig*)>& adjust = {});

  /// Uses another store.
  TestService(Transport transport,
              std::unique_ptr<Store> store,
              const std::function<void(ServerConfig*)>& adjust = {});
  ~TestService();

  /// Stops the server, as in a restart, and starts it again with the same memory store.
  void Restart();

  Server& server() { return *server_; }

  /// The test's own handle to the memory store.
  MemoryStore& store() { return *memory_store_; }

  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  v1::MapService::Stub& maps() { return *maps_; }

  v1::IngestService::Stub& ingest() { return *ingest_; }

  v1::QueryService::Stub& queries() { return *queries_; }

  /// Creates `tenants/test/maps/{id}`, with a byte budget unless it is 0; returns its name.
  std::string CreateMap(const std::string& id, std::uint64_t byte_budget = 0);

  /// Creates `tenants/test/maps/{id}` with the policy POCD; returns its name.
  std::string CreatePocdMap(const std::string& id);

  /// Returns the current map.
  absl::StatusOr<v1::Map> GetMap(const std::string& name);

  /// Deletes a map.
  absl::Status DeleteMap(const std::string& name);

  /// Returns the complete file of an export.
  absl::StatusOr<std::string> Export(const std::string& name, v1::ExportFormat format);
  absl::StatusOr<std::string> Export(const v1::ExportMapRequest& request);

 private:
  std::string CreateMap(const std::string& id, const v1::Map& map);
  void Start(std::unique_ptr<Store> store);

  Transport transport_;
  ServerConfig config_;
  std::unique_ptr<MemoryStore> memory_store_;
  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::MapService::Stub> maps_;
  std::unique_ptr<v1::IngestService::Stub> ingest_;
  std::unique_ptr<v1::QueryService::Stub> queries_;
};

/// Sets a deadline that is reached only if the call hangs.
void SetDeadline(grpc::ClientContext* context);

/// Makes one unary call: `Call([&](auto* context) { return stub.Method(context, ...); })`.
template <typename Method>
absl::Status Call(const Method& method) {
  grpc::ClientContext context;
  SetDeadline(&context);
  return FromGrpcStatus(method(&context));
}

/// Matches an error by code, reason and field path.
MATCHER_P3(IsError, code, reason, field, "") {
  *result_listener << arg.ToString() << " [" << ReasonOf(arg) << ", " << FieldOf(arg) << "]";
  return arg.code() == code && ReasonOf(arg) == reason && FieldOf(arg) == field;
}

}  // namespace steadymap

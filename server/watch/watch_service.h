#pragma once

#include "server/watch/watch_stream.h"

#include "steadymap/v1/watch_service.grpc.pb.h"

namespace steadymap {

/// Lets clients watch maps; see proto/steadymap/v1/watch_service.proto. Its messages are made and
/// serialized once for all who get the same, which is why gRPC is handed bytes.
class WatchService final
    : public v1::WatchService::WithRawCallbackMethod_WatchMap<v1::WatchService::Service> {
 public:
  explicit WatchService(const WatchStream::Dependencies& dependencies)
      : dependencies_(dependencies) {}

  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchMap(grpc::CallbackServerContext* context,
                                                       const grpc::ByteBuffer* request) override {
    return WatchStream::Start(dependencies_, context, *request);
  }

 private:
  const WatchStream::Dependencies dependencies_;
};

}  // namespace steadymap

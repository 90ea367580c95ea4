#pragma once

#include "server/watch/watch_stream.h"

#include "steadymap/v1/watch_service.grpc.pb.h"

namespace steadymap {

/// The watch service for clients; see proto/steadymap/v1/watch_service.proto. Equal messages for
/// several clients are made and serialized once; therefore gRPC receives them as bytes.
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

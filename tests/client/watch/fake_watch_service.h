#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include <absl/synchronization/notification.h>

#include "steadymap/v1/watch_service.grpc.pb.h"

namespace steadymap {

/// The server's end of one watch, for a script.
class ScriptedWatch {
 public:
  using Stream = grpc::ServerWriter<v1::WatchMapResponse>;

  ScriptedWatch(const v1::WatchMapRequest& asked, Stream* stream, absl::Notification* released)
      : request(asked), stream_(stream), released_(released) {}

  const v1::WatchMapRequest request;

  void Send(const std::vector<v1::WatchMapResponse>& messages) {
    for (const v1::WatchMapResponse& message : messages) stream_->Write(message);
  }

  /// Keeps the stream open until the test ends.
  grpc::Status Hold() {
    released_->WaitForNotification();
    return grpc::Status::OK;
  }

 private:
  Stream* stream_;
  absl::Notification* released_;
};

/// Plays one script per watch, in order; holds further watches open without messages.
class FakeWatchService final : public v1::WatchService::Service {
 public:
  using Script = std::function<grpc::Status(ScriptedWatch&)>;

  explicit FakeWatchService(std::vector<Script> scripts = {})
      : scripts_(scripts.begin(), scripts.end()) {}

  /// Replaces the scripts; call before the first watch.
  void SetScripts(std::vector<Script> scripts) { scripts_.assign(scripts.begin(), scripts.end()); }

  /// Ends all watches that are held open; call before the server is destroyed.
  void Release() { released_.Notify(); }

  /// Returns the requests so far, one per watch.
  std::vector<v1::WatchMapRequest> requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
  }

  grpc::Status WatchMap(grpc::ServerContext*,
                        const v1::WatchMapRequest* request,
                        ScriptedWatch::Stream* stream) override {
    ScriptedWatch watch(*request, stream, &released_);
    return NextScript(*request)(watch);
  }

 private:
  Script NextScript(const v1::WatchMapRequest& request) {
    const std::lock_guard lock(mutex_);
    requests_.push_back(request);
    if (scripts_.empty()) return [](ScriptedWatch& watch) { return watch.Hold(); };
    Script script = std::move(scripts_.front());
    scripts_.pop_front();
    return script;
  }

  mutable std::mutex mutex_;
  std::deque<Script> scripts_;
  std::vector<v1::WatchMapRequest> requests_;
  absl::Notification released_;
};

}  // namespace steadymap

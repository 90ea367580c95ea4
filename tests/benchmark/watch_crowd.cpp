#include "tests/benchmark/watch_crowd.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <stdexcept>
#include <thread>
#include <utility>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>
#include <google/protobuf/io/coded_stream.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/security/credentials.h>

namespace steadymap::benchmarks {
namespace {

constexpr char kMethod[] = "/steadymap.v1.WatchService/WatchMap";

// Much more than any opening takes.
constexpr absl::Duration kOpenLimit = absl::Seconds(60);

// Enough for the kind of a message, its length and the revision at its beginning.
constexpr std::size_t kHeadBytes = 32;

/// Content of the first bytes of a `WatchMapResponse`.
struct MessageHead {
  int kind = 0;  ///< Field number in the oneof.
  std::uint64_t revision = 0;
};

MessageHead ReadHead(const grpc::ByteBuffer& message) {
  std::vector<grpc::Slice> slices;
  message.Dump(&slices);
  std::array<std::uint8_t, kHeadBytes> bytes{};
  std::size_t count = 0;
  for (const grpc::Slice& slice : slices) {
    const std::size_t taken = std::min(bytes.size() - count, slice.size());
    std::copy_n(slice.begin(), taken, bytes.begin() + static_cast<std::ptrdiff_t>(count));
    count += taken;
    if (count == bytes.size()) break;
  }
  google::protobuf::io::CodedInputStream stream(bytes.data(), static_cast<int>(count));
  MessageHead head;
  std::uint32_t length = 0;
  head.kind = static_cast<int>(stream.ReadTag() >> 3U);
  constexpr std::uint32_t kRevisionTag = 1U << 3U;
  if (stream.ReadVarint32(&length) && stream.ReadTag() == kRevisionTag) {
    stream.ReadVarint64(&head.revision);
  }
  return head;
}

grpc::ByteBuffer Pack(const v1::WatchMapRequest& request) {
  const grpc::Slice bytes(request.SerializeAsString());
  return {&bytes, 1};
}

std::shared_ptr<grpc::Channel> OpenConnection(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  // By default all channels share one connection.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

/// One watcher. Not thread-safe: its crowd holds a mutex.
class Watcher {
 public:
  enum class Place { kStart, kWrite, kRead, kFinish };

  /// Tag of a completion queue event.
  struct Tag {
    Watcher* watcher = nullptr;
    Place place = Place::kStart;
  };

  /// `queue` and `channel` must outlive the watcher's calls.
  Watcher(const WatcherPlan& plan,
          const std::shared_ptr<grpc::Channel>& channel,
          grpc::CompletionQueue* queue)
      : plan_(plan), stub_(channel), call_(stub_.PrepareCall(&context_, kMethod, queue)) {
    call_->StartCall(&tags_[0]);
  }

  /// Cancels the call; its end is no error afterwards.
  void Cancel() {
    cancelled_ = true;
    context_.TryCancel();
  }

  void OnReport(Place place, bool ok) {
    if (place == Place::kFinish) {
      finished_ = true;
      if (!cancelled_) record_.end = "ended early: " + status_.error_message();
    } else if (!ok) {
      call_->Finish(&status_, &tags_[3]);
    } else if (place == Place::kStart) {
      call_->WriteLast(Pack(plan_.request), grpc::WriteOptions(), &tags_[1]);
    } else {
      if (place == Place::kRead) Take();
      if (stalls()) return;
      call_->Read(&message_, &tags_[2]);
    }
  }

  /// Begins the end of a stalled watcher, which has no pending operation.
  void FinishStalled() { call_->Finish(&status_, &tags_[3]); }

  bool stalls() const {
    return plan_.stalls_after > 0 && read_ >= plan_.stalls_after && !finished_;
  }

  bool opened() const { return opened_; }

  bool finished() const { return finished_; }

  /// True if the watcher has `revision` or has stopped reading.
  bool Has(std::uint64_t revision) const { return plan_.stalls_after > 0 || revision_ >= revision; }

  WatcherRecord TakeRecord() {
    record_.stalled = plan_.stalls_after > 0;
    return std::move(record_);
  }

 private:
  void Take() {
    const Clock::time_point now = Clock::now();
    ++read_;
    const MessageHead head = ReadHead(message_);
    if (head.kind == v1::WatchMapResponse::kCreated) {
      opened_ = true;
      return;
    }
    if (step_.messages == 0) step_.first = now;
    ++step_.messages;
    step_.bytes += message_.Length();
    if (plan_.keeps) Keep();
    if (head.kind != v1::WatchMapResponse::kProgress) return;
    step_.revision = head.revision;
    step_.last = now;
    revision_ = head.revision;
    record_.steps.push_back(std::exchange(step_, {}));
  }

  void Keep() {
    std::vector<grpc::Slice> slices;
    message_.Dump(&slices);
    std::string bytes;
    for (const grpc::Slice& slice : slices) {
      bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
    record_.messages.emplace_back().ParseFromString(bytes);
  }

  const WatcherPlan plan_;
  std::array<Tag, 4> tags_{Tag{this, Place::kStart},
                           Tag{this, Place::kWrite},
                           Tag{this, Place::kRead},
                           Tag{this, Place::kFinish}};
  grpc::ClientContext context_;
  grpc::GenericStub stub_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
  grpc::ByteBuffer message_;
  grpc::Status status_;
  WatchedStep step_;
  WatcherRecord record_;
  std::uint64_t revision_ = 0;
  std::size_t read_ = 0;  ///< Messages.
  bool opened_ = false;
  bool cancelled_ = false;
  bool finished_ = false;
};

}  // namespace

class WatchCrowd::Parts {
 public:
  Parts(const std::string& address,
        std::size_t connections,
        const std::vector<WatcherPlan>& plans) {
    for (std::size_t i = 0; i < std::min(connections, plans.size()); ++i) {
      channels_.push_back(OpenConnection(address));
    }
    thread_ = std::thread([this] { Run(); });
    const absl::MutexLock lock(&mutex_);
    for (std::size_t i = 0; i < plans.size(); ++i) {
      watchers_.push_back(
          std::make_unique<Watcher>(plans[i], channels_[i % channels_.size()], &queue_));
    }
  }

  ~Parts() { Stop(); }

  bool Await(absl::Duration limit, const std::function<bool(const Watcher&)>& holds) {
    const auto all_hold = [this, &holds]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return std::all_of(watchers_.begin(), watchers_.end(), [&holds](const auto& watcher) {
        return watcher->finished() || holds(*watcher);
      });
    };
    const absl::MutexLock lock(&mutex_);
    return mutex_.AwaitWithTimeout(absl::Condition(&all_hold), limit);
  }

  void Stop() {
    if (!thread_.joinable()) return;
    {
      const absl::MutexLock lock(&mutex_);
      for (const auto& watcher : watchers_) {
        watcher->Cancel();
        if (watcher->stalls()) watcher->FinishStalled();
      }
    }
    Await(kOpenLimit, [](const Watcher& watcher) { return watcher.finished(); });
    queue_.Shutdown();
    thread_.join();
  }

  std::vector<WatcherRecord> Records() {
    std::vector<WatcherRecord> records;
    const absl::MutexLock lock(&mutex_);
    for (const auto& watcher : watchers_) records.push_back(watcher->TakeRecord());
    return records;
  }

 private:
  void Run() {
    void* tag = nullptr;
    bool ok = false;
    while (queue_.Next(&tag, &ok)) {
      const auto* report = static_cast<const Watcher::Tag*>(tag);
      const absl::MutexLock lock(&mutex_);
      report->watcher->OnReport(report->place, ok);
    }
  }

  std::vector<std::shared_ptr<grpc::Channel>> channels_;
  grpc::CompletionQueue queue_;
  absl::Mutex mutex_;
  std::vector<std::unique_ptr<Watcher>> watchers_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

WatchCrowd::WatchCrowd(const std::string& address,
                       std::size_t connections,
                       const std::vector<WatcherPlan>& plans)
    : parts_(std::make_unique<Parts>(address, connections, plans)) {
  if (!parts_->Await(kOpenLimit, [](const Watcher& watcher) { return watcher.opened(); })) {
    throw std::runtime_error("watches did not open");
  }
}

WatchCrowd::~WatchCrowd() = default;

bool WatchCrowd::AwaitRevision(std::uint64_t revision, std::chrono::seconds limit) {
  return parts_->Await(absl::FromChrono(limit),
                       [revision](const Watcher& watcher) { return watcher.Has(revision); });
}

std::vector<WatcherRecord> WatchCrowd::Finish() {
  parts_->Stop();
  return parts_->Records();
}

}  // namespace steadymap::benchmarks

#include "tests/contract/watch_client.h"

#include <iterator>
#include <utility>

namespace steadymap {
namespace {

template <typename Message, typename Entries>
void Append(const Entries& entries, std::vector<Message>* all) {
  all->insert(all->end(), entries.begin(), entries.end());
}

void Join(ToldStep step, ToldStep* whole) {
  if (step.created) whole->created = step.created;
  if (step.resync) whole->resync = step.resync;
  Append(step.snapshot, &whole->snapshot);
  Append(step.delta, &whole->delta);
  Append(step.events, &whole->events);
  whole->progress = std::move(step.progress);
}

}  // namespace

std::vector<v1::Object> ToldStep::Objects() const {
  std::vector<v1::Object> objects;
  for (const v1::SnapshotChunk& chunk : snapshot) Append(chunk.objects(), &objects);
  for (const v1::DeltaFragment& fragment : delta) Append(fragment.objects(), &objects);
  return objects;
}

std::vector<v1::PackedLeaf> ToldStep::Leaves() const {
  std::vector<v1::PackedLeaf> leaves;
  for (const v1::SnapshotChunk& chunk : snapshot) Append(chunk.leaves(), &leaves);
  for (const v1::DeltaFragment& fragment : delta) Append(fragment.leaves(), &leaves);
  return leaves;
}

std::vector<std::uint64_t> ToldStep::Removed() const {
  std::vector<std::uint64_t> removed;
  for (const v1::DeltaFragment& fragment : delta) {
    Append(fragment.removed_object_ids(), &removed);
  }
  return removed;
}

WatchClient::WatchClient(v1::WatchService::StubInterface* stub,
                         const v1::WatchMapRequest& request) {
  SetDeadline(&context_);
  stream_ = stub->WatchMap(&context_, request);
}

WatchClient::~WatchClient() {
  if (ended_) return;
  Cancel();
  End().IgnoreError();
}

std::optional<v1::WatchMapResponse> WatchClient::Read() {
  v1::WatchMapResponse message;
  if (!stream_->Read(&message)) return std::nullopt;
  was_told_goodbye_ = was_told_goodbye_ || message.has_goodbye();
  return message;
}

std::optional<ToldStep> WatchClient::ReadStep() {
  ToldStep step;
  while (std::optional<v1::WatchMapResponse> message = Read()) {
    switch (message->kind_case()) {
      case v1::WatchMapResponse::kCreated:
        step.created = message->created();
        break;
      case v1::WatchMapResponse::kResync:
        step.resync = message->resync();
        break;
      case v1::WatchMapResponse::kSnapshot:
        step.snapshot.push_back(std::move(*message->mutable_snapshot()));
        break;
      case v1::WatchMapResponse::kDelta:
        step.delta.push_back(std::move(*message->mutable_delta()));
        break;
      case v1::WatchMapResponse::kEvents:
        Append(message->events().events(), &step.events);
        break;
      case v1::WatchMapResponse::kProgress:
        step.progress = message->progress();
        return step;
      default:
        break;
    }
  }
  return std::nullopt;
}

std::optional<ToldStep> WatchClient::ReadUntil(std::uint64_t revision) {
  ToldStep whole;
  while (whole.progress.revision() < revision) {
    std::optional<ToldStep> step = ReadStep();
    if (!step) return std::nullopt;
    Join(*std::move(step), &whole);
  }
  return whole;
}

absl::Status WatchClient::End() {
  while (Read()) {
  }
  ended_ = true;
  return FromGrpcStatus(stream_->Finish());
}

}  // namespace steadymap

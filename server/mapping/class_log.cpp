#include "server/mapping/class_log.h"

#include <utility>

namespace steadymap {

ClassLog::ClassLog(const MapConfig& config)
    : config_(config),
      durable_(config.classes),
      labels_(std::make_shared<const KnownLabels>(config.classes)) {}

void ClassLog::Reset(std::vector<SemanticClass> durable) {
  const absl::MutexLock lock(&mutex_);
  durable_ = std::move(durable);
  labels_ = std::make_shared<const KnownLabels>(durable_);
}

void ClassLog::Append(const std::vector<SemanticClass>& added) {
  if (added.empty()) return;
  const absl::MutexLock lock(&mutex_);
  durable_.insert(durable_.end(), added.begin(), added.end());
  labels_ = std::make_shared<const KnownLabels>(durable_);
}

std::vector<SemanticClass> ClassLog::classes() const {
  const absl::MutexLock lock(&mutex_);
  return durable_;
}

std::shared_ptr<const KnownLabels> ClassLog::labels() const {
  const absl::MutexLock lock(&mutex_);
  return labels_;
}

absl::Status ClassLog::Queue(PendingClasses pending) {
  const absl::MutexLock lock(&mutex_);
  if (!closed_.ok()) return closed_;
  MapConfig config = config_;
  config.classes = durable_;
  const auto add = [&config](const std::vector<SemanticClass>& classes) {
    config.classes.insert(config.classes.end(), classes.begin(), classes.end());
  };
  for (const PendingClasses& queued : queued_) add(queued.classes);
  add(pending.classes);
  absl::Status status = ValidateMapConfig(config);
  if (status.ok()) queued_.push_back(std::move(pending));
  return status;
}

std::vector<PendingClasses> ClassLog::TakeQueued() {
  const absl::MutexLock lock(&mutex_);
  return std::exchange(queued_, {});
}

std::vector<PendingClasses> ClassLog::Close(const absl::Status& status) {
  const absl::MutexLock lock(&mutex_);
  closed_ = status;
  return std::exchange(queued_, {});
}

}  // namespace steadymap

#pragma once

#include <memory>

#include "server/watch/watch_hub.h"

namespace steadymap {

/// A watch that only records its calls.
class RecordingWatch final : public ActiveWatch {
 public:
  void Wake() override { ++wakes; }

  void Drain() override { ++drains; }

  void End(const absl::Status& status) override { ended = status; }

  void Cancel() override { ++cancels; }

  Revision revision() const override { return has; }

  std::shared_ptr<WatchMessages> step() const override { return nullptr; }

  absl::Time sending_since() const override { return since; }

  int wakes = 0;
  int drains = 0;
  int cancels = 0;
  absl::Status ended;
  Revision has;
  absl::Time since = absl::InfiniteFuture();
};

}  // namespace steadymap

#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// Small frames of a place where boxes are added, removed and moved: a few scenes, each observed
/// from a few poses, rendered once. For one thread.
class ChangingHall {
 public:
  ChangingHall();

  /// Switches to another scene, drawn from `random`.
  void Rearrange(std::mt19937* random);

  /// Returns the next `count` frames of the scene, half a second apart in capture time.
  std::vector<v1::Frame> Look(int count);

 private:
  std::vector<std::vector<v1::Frame>> scenes_;
  std::size_t scene_ = 0;
  std::uint64_t frames_ = 0;
};

}  // namespace steadymap

#pragma once

#include <cstddef>
#include <vector>

#include <sys/types.h>

namespace steadymap {

/// Counts sockets that somebody else owns and closes: gRPC says nothing of connections that end. A
/// socket is known by its descriptor and its inode, since the next file gets the same descriptor.
class OpenSockets {
 public:
  /// Counts a socket from now on.
  void Add(int descriptor);

  /// How many were not closed yet, at most: those that were closed are forgotten if there seem to
  /// be `enough`, at the cost of a system call each.
  std::size_t Count(std::size_t enough);

 private:
  struct Entry {
    int descriptor = -1;
    ino_t inode = 0;
  };

  std::vector<Entry> entries_;
};

}  // namespace steadymap

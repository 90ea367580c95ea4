#pragma once

#include <cstddef>
#include <vector>

#include <sys/types.h>

namespace steadymap {

/// Counts sockets that gRPC owns and closes, because gRPC does not report the end of a connection.
/// A socket is identified by its descriptor and its inode, because the system reuses descriptors.
class OpenSockets {
 public:
  /// Starts to count a socket.
  void Add(int descriptor);

  /// Returns an upper bound on the number of open sockets. If that bound reaches `enough`, first
  /// removes the closed sockets, at the cost of one system call per socket.
  std::size_t Count(std::size_t enough);

 private:
  struct Entry {
    int descriptor = -1;
    ino_t inode = 0;
  };

  std::vector<Entry> entries_;
};

}  // namespace steadymap

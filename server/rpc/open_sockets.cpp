#include "server/rpc/open_sockets.h"

#include <optional>

#include <sys/stat.h>

namespace steadymap {
namespace {

/// Returns the inode of an open socket; none for any other descriptor.
std::optional<ino_t> SocketInode(int descriptor) {
  struct stat file {};

  if (::fstat(descriptor, &file) != 0 || !S_ISSOCK(file.st_mode)) return std::nullopt;
  return file.st_ino;
}

}  // namespace

void OpenSockets::Add(int descriptor) {
  if (const auto inode = SocketInode(descriptor)) entries_.push_back({descriptor, *inode});
}

std::size_t OpenSockets::Count(std::size_t enough) {
  if (entries_.size() >= enough) {
    std::erase_if(entries_,
                  [](const Entry& entry) { return SocketInode(entry.descriptor) != entry.inode; });
  }
  return entries_.size();
}

}  // namespace steadymap

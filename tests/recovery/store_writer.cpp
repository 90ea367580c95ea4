// Appends and commits frames to one map of a store until it ends, and prints a line for each
// durable write: `durable N` or `revision N`. For tests that kill it.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "server/store/model/store.h"
#include "tests/server/store/store_builder.h"

namespace steadymap {
namespace {

constexpr std::uint64_t kFramesPerCommit = 5;

int Write(const char* folder) {
  absl::StatusOr<std::unique_ptr<Store>> store = Store::Open(folder, StoreOptions());
  if (!store.ok()) return EXIT_FAILURE;
  std::vector<MapRecord> maps = (*store)->ListMaps().value();
  if (maps.empty()) maps.push_back((*store)->CreateMap(MakeMapRecord("acme", "hall")).value());
  const StoredState state = (*store)->LoadMap(maps.front()).value();
  std::uint64_t revision = state.snapshot.revision.value();
  for (std::uint64_t head = state.durable_head.value() + 1;; ++head) {
    if (!(*store)->Append(MakeAppend(maps.front().key, head, 1)).ok()) return EXIT_FAILURE;
    std::printf("durable %lu\n", head);
    std::fflush(stdout);
    if (head % kFramesPerCommit != 0) continue;
    const MapDelta delta =
        MakeDelta(revision, head, {MakeLeaf(0, 0, 0, static_cast<std::uint32_t>(head))});
    if (!(*store)->CommitRevision(maps.front().key, delta, MakeDetails(delta)).ok())
      return EXIT_FAILURE;
    revision = head;
    std::printf("revision %lu\n", head);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace steadymap

int main(int argument_count, char** arguments) {
  return argument_count == 2 ? steadymap::Write(arguments[1]) : EXIT_FAILURE;
}

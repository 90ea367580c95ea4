// Begins to integrate an entry of a store's only map of that name and ends by a signal, like a
// server with a crash in its mapping: `entry_crasher FOLDER MAP ENTRY SIGNAL`.

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <sys/resource.h>

#include "server/store/model/store.h"

namespace steadymap {
namespace {

int EndOn(const char* folder, const std::string& name, std::uint64_t sequence, int signal) {
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  IntegrationNote::InstallCrashHandlers();
  const absl::StatusOr<std::unique_ptr<Store>> store = Store::Open(folder, StoreOptions());
  if (!store.ok()) return EXIT_FAILURE;
  const std::vector<MapRecord> maps = (*store)->ListMaps().value();
  for (const MapRecord& map : maps) {
    if (map.name.map != name) continue;
    const absl::StatusOr<StoredState> state = (*store)->LoadMap(map);
    if (!state.ok()) return EXIT_FAILURE;
    state->note->Begin(MapSequence(sequence));
    std::raise(signal);
  }
  return EXIT_FAILURE;
}

}  // namespace
}  // namespace steadymap

int main(int argument_count, char** arguments) {
  if (argument_count != 5) return EXIT_FAILURE;
  return steadymap::EndOn(arguments[1],
                          arguments[2],
                          std::strtoull(arguments[3], nullptr, 10),
                          std::atoi(arguments[4]));
}

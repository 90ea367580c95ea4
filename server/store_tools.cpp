#include "server/store_tools.h"

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include "server/process/logging.h"
#include "server/store/repair/map_salvage.h"
#include "server/store/repair/store_check.h"

namespace steadymap {
namespace {

int CannotRun(const absl::Status& status) {
  std::fprintf(stderr, "steadymapd: %s\n", std::string(status.message()).c_str());
  return kExitCannotRun;
}

void PrintLines(const std::string& title, const std::vector<std::string>& lines) {
  std::printf("%s\n", title.c_str());
  for (const std::string& line : lines) std::printf("  %s\n", line.c_str());
}

/// `tenants/TENANT/maps/MAP` or `TENANT/MAP`.
absl::StatusOr<MapName> ParseName(const std::string& name) {
  const std::size_t slash = name.find('/');
  if (slash != std::string::npos && name.find('/', slash + 1) == std::string::npos) {
    return MapName::Parse("tenants/" + name.substr(0, slash) + "/maps/" + name.substr(slash + 1));
  }
  return MapName::Parse(name);
}

int RunCheck(const ServerConfig& config, const std::optional<MapName>& map) {
  const absl::StatusOr<StoreCheckResult> findings = CheckStore(config.data_dir, map);
  if (!findings.ok()) return CannotRun(findings.status());
  if (!findings->problems.empty()) PrintLines("store: damaged", findings->problems);
  for (const MapCheckResult& found : findings->maps) {
    const char* const verdict = found.problems.empty() ? ": OK" : ": damaged";
    PrintLines(found.name.ToString() + verdict, found.problems);
  }
  return findings->ok() ? EXIT_SUCCESS : kExitFailure;
}

int RunSalvage(const CommandLine& command_line, const ServerConfig& config, const MapName& map) {
  SalvageOptions options{config.data_dir, map};
  if (command_line.skip_entry) options.skip_entry = MapSequence(*command_line.skip_entry);
  options.output = command_line.output;
  const absl::StatusOr<SalvageReport> report = SalvageMap(options);
  if (!report.ok()) return CannotRun(report.status());
  PrintLines(map.ToString() + ": salvaged", report->remarks);
  std::printf("  the repaired map is in %s\n  its old files are in %s\n",
              report->repaired.c_str(),
              report->old_files.c_str());
  return EXIT_SUCCESS;
}

}  // namespace

int RunStoreTool(const CommandLine& command_line, const ServerConfig& config) {
  StartLogging(config.log);
  std::optional<MapName> map;
  if (!command_line.map.empty()) {
    absl::StatusOr<MapName> name = ParseName(command_line.map);
    if (!name.ok()) return CannotRun(name.status());
    map = *std::move(name);
  }
  return command_line.command == Command::kCheck ? RunCheck(config, map)
                                                 : RunSalvage(command_line, config, *map);
}

}  // namespace steadymap

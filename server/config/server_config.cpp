#include "server/config/server_config.h"

#include <optional>
#include <string_view>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include "core/types/absl_text.h"
#include "server/config/config_fields.h"
#include "server/config/listen_address.h"

namespace steadymap {
namespace {

/// Collects the integers that are out of range.
class RangeChecker final : public FieldVisitor {
 public:
  explicit RangeChecker(std::vector<std::string>* violations) : violations_(violations) {}

  void Section(std::string_view name, std::string_view /*documentation*/) override {
    prefix_ = std::string(name) + ".";
  }

  void Text(const FieldName& /*field*/, std::string* /*value*/) override {}

  void Flag(const FieldName& /*field*/, bool* /*value*/) override {}

  void Integer(const FieldName& field, const IntegerRange& range, std::int64_t* value) override {
    if (*value >= range.min && *value <= range.max) return;
    violations_->push_back(absl::StrCat(prefix_,
                                        Absl(field.name),
                                        " must lie in [",
                                        range.min,
                                        ", ",
                                        range.max,
                                        "], got ",
                                        *value));
  }

  void Choice(const FieldName& /*field*/,
              std::span<const std::string_view> /*choices*/,
              std::size_t* /*value*/) override {}

 private:
  std::string prefix_;
  std::vector<std::string>* violations_;
};

/// Lists all fields with their values as text.
class FieldLister final : public FieldVisitor {
 public:
  struct Field {
    std::string name;  ///< Includes the section.
    std::string value;
  };

  static std::vector<Field> List(const ServerConfig& config) {
    ServerConfig copy = config;
    FieldLister lister;
    VisitFields(&copy, &lister);
    return std::move(lister.fields_);
  }

  void Section(std::string_view name, std::string_view /*documentation*/) override {
    prefix_ = std::string(name) + ".";
  }

  void Text(const FieldName& field, std::string* value) override { Add(field, *value); }

  void Flag(const FieldName& field, bool* value) override { Add(field, *value ? "true" : "false"); }

  void Integer(const FieldName& field,
               const IntegerRange& /*range*/,
               std::int64_t* value) override {
    Add(field, absl::StrCat(*value));
  }

  void Choice(const FieldName& field,
              std::span<const std::string_view> choices,
              std::size_t* value) override {
    Add(field, std::string(choices[*value]));
  }

 private:
  void Add(const FieldName& field, std::string value) {
    fields_.push_back({prefix_ + std::string(field.name), std::move(value)});
  }

  std::string prefix_;
  std::vector<Field> fields_;
};

void CheckListen(const ServerConfig& config, std::vector<std::string>* violations) {
  if (!ParseListenAddress(config.listen)) {
    violations->push_back("listen must read HOST:PORT or unix:PATH, got \"" + config.listen + "\"");
    return;
  }
  if (!IsLoopback(config.listen) && !config.allow_plaintext_remote) {
    violations->push_back("listen = \"" + config.listen +
                          "\" accepts unencrypted connections from other machines; listen on "
                          "localhost, or set allow_plaintext_remote = true to allow this");
  }
}

}  // namespace

std::vector<std::string> FindViolations(const ServerConfig& config) {
  std::vector<std::string> violations;
  ServerConfig copy = config;
  RangeChecker checker(&violations);
  VisitFields(&copy, &checker);
  CheckListen(config, &violations);
  if (config.data_dir.empty()) violations.emplace_back("data_dir must name a folder, got \"\"");
  const LimitOptions& limits = config.limits;
  const auto at_least = [&](const char* larger,
                            std::size_t value,
                            const char* smaller,
                            std::size_t bound) {
    if (value >= bound) return;
    violations.push_back(absl::StrCat(
        "limits.", larger, " must be at least limits.", smaller, " (", bound, "), got ", value));
  };
  at_least("upload_window_bytes",
           limits.upload_window_bytes,
           "max_message_bytes",
           limits.max_message_bytes);
  at_least("queue_bytes_per_map",
           limits.queue_bytes_per_map,
           "upload_window_bytes",
           limits.upload_window_bytes);
  at_least("queue_bytes_total",
           limits.queue_bytes_total,
           "queue_bytes_per_map",
           limits.queue_bytes_per_map);
  // RocksDB needs the space for a buffer when it flushes a full buffer, and again when it compacts
  // the flushed files.
  constexpr std::uint64_t kReserveFactor = 3;
  const StoreOptions& store = config.store;
  if (store.min_free_disk_bytes / kReserveFactor < store.write_buffer_bytes) {
    violations.push_back(absl::StrCat("store.min_free_disk_bytes must be at least ",
                                      kReserveFactor,
                                      " times store.write_buffer_bytes (",
                                      kReserveFactor,
                                      " x ",
                                      store.write_buffer_bytes,
                                      "), got ",
                                      store.min_free_disk_bytes,
                                      ": the contents of the write buffers must fit on the disk"));
  }
  return violations;
}

absl::Status ValidateServerConfig(const ServerConfig& config) {
  const std::vector<std::string> violations = FindViolations(config);
  if (violations.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrJoin(violations, "\n"));
}

void ApplyReloadable(const ServerConfig& fresh, ServerConfig* running) {
  running->log.level = fresh.log.level;
  running->drain_timeout = fresh.drain_timeout;
  const std::size_t max_message_bytes = running->limits.max_message_bytes;
  running->limits = fresh.limits;
  // gRPC has a corresponding limit, which is set only at the start of the server.
  running->limits.max_message_bytes = max_message_bytes;
}

std::vector<std::string> FindDifferences(const ServerConfig& before, const ServerConfig& after) {
  const std::vector<FieldLister::Field> old_fields = FieldLister::List(before);
  const std::vector<FieldLister::Field> new_fields = FieldLister::List(after);
  std::vector<std::string> differences;
  for (std::size_t i = 0; i < old_fields.size(); ++i) {
    if (old_fields[i].value == new_fields[i].value) continue;
    differences.push_back(
        absl::StrCat(old_fields[i].name, ": ", old_fields[i].value, " -> ", new_fields[i].value));
  }
  return differences;
}

bool IsLoopback(const std::string& listen) {
  const std::optional<ListenAddress> address = ParseListenAddress(listen);
  if (!address) return false;
  if (!address->unix_path.empty()) return true;
  if (address->host == "localhost" || address->host == "::1") return true;
  // Accepts 127.0.0.0/8, but not a host name that begins with "127.".
  return address->host.starts_with("127.") &&
         address->host.find_first_not_of("0123456789.") == std::string::npos;
}

std::string WithPort(const std::string& listen, int port) {
  const std::optional<ListenAddress> address = ParseListenAddress(listen);
  if (!address || !address->unix_path.empty()) return listen;
  return listen.substr(0, listen.rfind(':') + 1) + std::to_string(port);
}

}  // namespace steadymap

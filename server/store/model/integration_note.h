#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include <absl/status/statusor.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// Records the log entry of a map that is being integrated, and the newest durable entry and
/// revision of the map. The record survives the end of the process. It identifies an entry whose
/// integration ends the process repeatedly, and detects a log or a database that has lost its end.
///
/// The record is a small file mapped into memory: an update needs no system call, and it survives
/// any end of the process. A power cut may revert the file to an older state. The file is never
/// ahead of the data on disk.
///
/// `Begin`, `End` and `AgeAll` may be called from any thread, one at a time for each map.
class IntegrationNote {
 public:
  /// An entry whose integration ended or failed in one or more processes.
  struct Suspect {
    MapSequence sequence;
    std::uint32_t crashes = 0;  ///< Number of consecutive process ends during its integration.
  };

  /// A killed process counts against the entry being integrated only if the integration had taken
  /// this long, because a process can be killed for other reasons. A crash counts in any case.
  static constexpr std::uint32_t kSuspiciousMs = 2000;

  /// Opens the note in `file`, and creates it if it does not exist. A damaged file is replaced by
  /// an empty note, because no part of its content is vital. Errors: as `PosixFile`.
  static absl::StatusOr<std::shared_ptr<IntegrationNote>> Open(const std::filesystem::path& file);

  /// Returns a copy of the note in `file` for inspection, without changing the file. Returns an
  /// empty note if the file is missing or damaged. Errors: as `PosixFile`.
  static absl::StatusOr<std::shared_ptr<IntegrationNote>> Inspect(
      const std::filesystem::path& file);

  /// Returns a note without a file, for tests and for stores without a disk.
  static std::shared_ptr<IntegrationNote> InMemory();

  ~IntegrationNote();
  IntegrationNote(const IntegrationNote&) = delete;
  IntegrationNote& operator=(const IntegrationNote&) = delete;

  /// Returns the entry that is suspected to end or fail its process; none if no entry is suspected.
  const std::optional<Suspect>& suspect() const { return suspect_; }

  /// Marks the start of the integration of an entry on this thread and on its helper threads.
  void Begin(MapSequence sequence);

  /// Marks the end of the integration of the entry, or that the entry will not be integrated.
  void End();

  /// Marks a failed integration of the entry. It counts in the same way as an end of the process.
  void Fail();

  /// The newest durable entry at the time the note was opened; 0: unknown. `known_revision` is the
  /// newest durable revision at that time.
  MapSequence known_head() const { return known_head_; }

  Revision known_revision() const { return known_revision_; }

  /// Records the newest entry, or the newest revision, that is synced to disk.
  void NoteHead(MapSequence head);
  void NoteRevision(Revision revision);

  /// Records for all notes of the process how long their current integration has taken by `now`.
  /// Must be called periodically, because a killed process cannot record it.
  static void AgeAll(std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now());

  /// Installs signal handlers so that a crash of this process (SIGSEGV, SIGBUS, SIGFPE, SIGILL,
  /// SIGABRT) counts against the entry that the crashing thread integrates or helps to integrate.
  /// Call once, before threads are started.
  static void InstallCrashHandlers();

 private:
  struct Page;

  IntegrationNote(Page* page, bool is_mapped);

  void CountCrash();
  void Forgive();

  Page* const page_;
  const bool is_mapped_;
  std::optional<Suspect> suspect_;
  MapSequence known_head_;
  Revision known_revision_;
};

}  // namespace steadymap

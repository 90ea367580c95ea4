#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include <absl/status/statusor.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// Remembers beyond the end of the process which log entry of a map is being integrated, and how
/// far the map's log and revision had come. So an entry that ends the process each time it is
/// integrated is found out, and a log or database that has lost its end is noticed.
///
/// Kept in a small file that is mapped into memory: an update costs nothing, and survives whatever
/// ends the process. A power cut may set it back, never ahead of what is on disk.
///
/// `Begin`, `End` and `AgeAll` may be called from any thread, one at a time for a map.
class IntegrationNote {
 public:
  /// An entry that processes ended on.
  struct Suspect {
    MapSequence sequence;
    std::uint32_t crashes = 0;  ///< Processes that ended while it was integrated, in a row.
  };

  /// A process that is killed counts against the entry at hand only if that had taken so long by
  /// then: a kill has its own reasons. One that crashes counts at once.
  static constexpr std::uint32_t kSuspiciousMs = 2000;

  /// Opens the note in `file`, making it if need be. A file that is damaged is made anew: nothing
  /// that it says is vital. Errors: as `PosixFile`.
  static absl::StatusOr<std::shared_ptr<IntegrationNote>> Open(const std::filesystem::path& file);

  /// What the note in `file` says, to look at: the file stays as it is. A new one if it is missing
  /// or damaged. Errors: as `PosixFile`.
  static absl::StatusOr<std::shared_ptr<IntegrationNote>> Inspect(
      const std::filesystem::path& file);

  /// A note that ends with the process, for tests and stores without a disk.
  static std::shared_ptr<IntegrationNote> InMemory();

  ~IntegrationNote();
  IntegrationNote(const IntegrationNote&) = delete;
  IntegrationNote& operator=(const IntegrationNote&) = delete;

  /// The entry that processes ended on, or failed at, if that speaks against it.
  const std::optional<Suspect>& suspect() const { return suspect_; }

  /// An entry is about to be integrated on this thread, and on those that help it.
  void Begin(MapSequence sequence);

  /// It was integrated, or is not going to be.
  void End();

  /// It could not be integrated: that counts as if the process had ended on it.
  void Fail();

  /// What was durable when the note was opened; 0: nothing is known.
  MapSequence known_head() const { return known_head_; }

  Revision known_revision() const { return known_revision_; }

  /// The log, or the revision, has come so far, synced.
  void NoteHead(MapSequence head);
  void NoteRevision(Revision revision);

  /// Notes how long the entries at hand have taken by `now`, for all notes of the process. To be
  /// called now and then: a process that is killed can tell no more.
  static void AgeAll(std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now());

  /// Makes crashes of this process (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT) speak against the
  /// entry that the crashing thread integrates, or helps to. Call once, before threads are started.
  static void CatchCrashes();

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

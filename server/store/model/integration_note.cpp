#include "server/store/model/integration_note.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <new>
#include <set>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <fcntl.h>
#include <sys/mman.h>

#include "core/types/parallel.h"
#include "server/store/disk/posix_file.h"

namespace steadymap {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kMagic = 0x3245544F4E4D5331ULL;  // "1SMNOTE2"
constexpr std::array kCrashSignals = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

}  // namespace

/// The content of the file. Bytes of the file after it are not used.
struct IntegrationNote::Page {
  /// A number and its complement. A damaged number reads as 0, which means unknown.
  class CheckedNumber {
   public:
    std::uint64_t Get() const {
      const std::uint64_t value = value_;
      return value == ~complement_.load() ? value : 0;
    }

    void Set(std::uint64_t value) {
      value_ = value;
      complement_ = ~value;
    }

   private:
    std::atomic<std::uint64_t> value_ = 0;
    std::atomic<std::uint64_t> complement_ = ~std::uint64_t{0};
  };

  std::uint64_t magic = kMagic;

  std::atomic<std::uint64_t> sequence = 0;    ///< Entry being integrated; 0: none.
  std::atomic<std::uint32_t> elapsed_ms = 0;  ///< Duration of its integration at the last `AgeAll`.
  std::atomic<std::uint32_t> signal = 0;      ///< Signal that ended the process during it; 0: none.
  std::atomic<std::uint64_t> suspect_sequence = 0;
  std::atomic<std::uint32_t> suspect_crashes = 0;
  std::atomic<std::uint32_t> unused = 0;
  CheckedNumber head;
  CheckedNumber revision;
  /// Start of the integration by the steady clock of its process; meaningless in another process.
  std::atomic<Clock::rep> begun = 0;
};

namespace {

std::array<struct sigaction, 65> previous_actions{};

void NoteCrash(int signal) {
  // The work owner of a thread is the note of the entry that the thread integrates, or null.
  if (auto* noted = static_cast<std::atomic<std::uint32_t>*>(WorkOwner()); noted != nullptr) {
    noted->store(static_cast<std::uint32_t>(signal));
  }
  // The previous handler, in the end the default one, terminates the process.
  ::sigaction(signal, &previous_actions.at(static_cast<std::size_t>(signal)), nullptr);
  ::raise(signal);
}

}  // namespace

/// The registry of all notes of the process.
struct NoteRegistry {
  absl::Mutex mutex;
  std::set<IntegrationNote*> notes ABSL_GUARDED_BY(mutex);

  static NoteRegistry& Get() {
    static NoteRegistry registry;
    return registry;
  }
};

IntegrationNote::IntegrationNote(Page* page, bool is_mapped) : page_(page), is_mapped_(is_mapped) {
  if (page_->signal != 0 || page_->elapsed_ms >= kSuspiciousMs) CountCrash();
  page_->sequence = 0;
  if (page_->suspect_sequence != 0) {
    suspect_ = Suspect{MapSequence(page_->suspect_sequence), page_->suspect_crashes};
  }
  known_head_ = MapSequence(page_->head.Get());
  known_revision_ = Revision(page_->revision.Get());
  NoteRegistry& registry = NoteRegistry::Get();
  const absl::MutexLock lock(&registry.mutex);
  registry.notes.insert(this);
}

IntegrationNote::~IntegrationNote() {
  {
    NoteRegistry& registry = NoteRegistry::Get();
    const absl::MutexLock lock(&registry.mutex);
    registry.notes.erase(this);
  }
  if (is_mapped_) {
    ::munmap(page_, sizeof(Page));
  } else {
    delete page_;
  }
}

absl::StatusOr<std::shared_ptr<IntegrationNote>> IntegrationNote::Open(
    const std::filesystem::path& file) {
  const absl::StatusOr<PosixFile> opened = PosixFile::Open(file, O_RDWR | O_CREAT);
  if (!opened.ok()) return opened.status();
  const absl::StatusOr<std::uint64_t> size = opened->Size();
  if (!size.ok()) return size.status();
  const bool is_new = *size < sizeof(Page);
  if (is_new) {
    // Writing to a mapped page without disk space would end the process with SIGBUS.
    if (absl::Status status = opened->Truncate(sizeof(Page)); !status.ok()) return status;
    if (absl::Status status = opened->Reserve(0, sizeof(Page)); !status.ok()) return status;
  }
  void* const memory =
      ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED, opened->descriptor(), 0);
  if (memory == MAP_FAILED) return SystemError(errno, "map", file);
  auto* page = static_cast<Page*>(memory);
  if (is_new || page->magic != kMagic) page = new (memory) Page();
  return std::shared_ptr<IntegrationNote>(new IntegrationNote(page, /*is_mapped=*/true));
}

absl::StatusOr<std::shared_ptr<IntegrationNote>> IntegrationNote::Inspect(
    const std::filesystem::path& file) {
  const absl::StatusOr<PosixFile> opened = PosixFile::Open(file, O_RDONLY);
  if (absl::IsNotFound(opened.status())) return InMemory();
  if (!opened.ok()) return opened.status();
  const absl::StatusOr<std::uint64_t> size = opened->Size();
  if (!size.ok()) return size.status();
  if (*size < sizeof(Page)) return InMemory();
  // Writes to a private mapping stay in memory.
  void* const memory =
      ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_PRIVATE, opened->descriptor(), 0);
  if (memory == MAP_FAILED) return SystemError(errno, "map", file);
  auto* page = static_cast<Page*>(memory);
  if (page->magic != kMagic) page = new (memory) Page();
  return std::shared_ptr<IntegrationNote>(new IntegrationNote(page, /*is_mapped=*/true));
}

std::shared_ptr<IntegrationNote> IntegrationNote::InMemory() {
  return std::shared_ptr<IntegrationNote>(new IntegrationNote(new Page(), /*is_mapped=*/false));
}

void IntegrationNote::Begin(MapSequence sequence) {
  page_->elapsed_ms = 0;
  page_->signal = 0;
  page_->begun = Clock::now().time_since_epoch().count();
  page_->sequence = sequence.value();
  SetWorkOwner(&page_->signal);
}

void IntegrationNote::End() {
  SetWorkOwner(nullptr);
  const std::uint64_t sequence = page_->sequence.exchange(0);
  if (sequence == page_->suspect_sequence) Forgive();
}

void IntegrationNote::Fail() {
  SetWorkOwner(nullptr);
  CountCrash();
  page_->sequence = 0;
}

/// Counts an end of the process against the entry being integrated, if there is one.
void IntegrationNote::CountCrash() {
  const std::uint64_t sequence = page_->sequence;
  if (sequence == 0) return;
  const bool again = page_->suspect_sequence == sequence;
  page_->suspect_crashes = again ? page_->suspect_crashes + 1 : 1;
  page_->suspect_sequence = sequence;
  suspect_ = Suspect{MapSequence(sequence), page_->suspect_crashes};
}

void IntegrationNote::Forgive() {
  page_->suspect_sequence = 0;
  page_->suspect_crashes = 0;
  suspect_.reset();
}

void IntegrationNote::NoteHead(MapSequence head) { page_->head.Set(head.value()); }

void IntegrationNote::NoteRevision(Revision revision) { page_->revision.Set(revision.value()); }

void IntegrationNote::AgeAll(Clock::time_point now) {
  NoteRegistry& registry = NoteRegistry::Get();
  const absl::MutexLock lock(&registry.mutex);
  for (IntegrationNote* note : registry.notes) {
    Page& page = *note->page_;
    if (page.sequence == 0) continue;
    const Clock::time_point begun{Clock::duration(page.begun.load())};
    page.elapsed_ms = static_cast<std::uint32_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(now - begun).count());
  }
}

void IntegrationNote::InstallCrashHandlers() {
  for (const int signal : kCrashSignals) {
    struct sigaction action {};

    action.sa_handler = NoteCrash;
    ::sigemptyset(&action.sa_mask);
    action.sa_flags = SA_NODEFER;
    ::sigaction(signal, &action, &previous_actions.at(static_cast<std::size_t>(signal)));
  }
}

}  // namespace steadymap

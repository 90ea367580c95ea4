// Tests the integration note of a map after processes with different ends.

#include "server/store/model/integration_note.h"

#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/types/parallel.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

class IntegrationNoteTest : public ::testing::Test {
 protected:
  std::shared_ptr<IntegrationNote> Open() { return IntegrationNote::Open(file_).value(); }

  /// Runs `body` with the opened note in a child process that catches crashes; returns the signal
  /// that ended it, 0 if none did.
  int InChild(const std::function<void(IntegrationNote*)>& body) {
    const pid_t child = ::fork();
    if (child == 0) {
      const rlimit no_core{0, 0};
      ::setrlimit(RLIMIT_CORE, &no_core);
      IntegrationNote::InstallCrashHandlers();
      body(Open().get());
      ::_exit(EXIT_SUCCESS);
    }
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }

  /// Runs a process that ends with `signal` while it integrates an entry.
  void EndOn(std::uint64_t sequence, int signal) {
    const int ended_by = InChild([=](IntegrationNote* note) {
      note->Begin(MapSequence(sequence));
      ::raise(signal);
    });
    EXPECT_EQ(ended_by, signal);
  }

  /// Expects that the note suspects `sequence` after this number of crashes.
  void ExpectSuspect(std::uint64_t sequence, std::uint32_t crashes) {
    const std::optional<IntegrationNote::Suspect> suspect = Open()->suspect();
    ASSERT_TRUE(suspect.has_value());
    EXPECT_EQ(suspect->sequence, MapSequence(sequence));
    EXPECT_EQ(suspect->crashes, crashes);
  }

  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "note";
};

TEST_F(IntegrationNoteTest, NewNoteKnowsNothing) {
  const std::shared_ptr<IntegrationNote> note = Open();
  EXPECT_FALSE(note->suspect().has_value());
  EXPECT_EQ(note->known_head(), MapSequence());
  EXPECT_EQ(note->known_revision(), Revision());
}

TEST_F(IntegrationNoteTest, CrashCountsAtOnceWhateverItsSignal) {
  std::uint32_t crashes = 0;
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) {
    EndOn(7, signal);
    ExpectSuspect(7, ++crashes);
  }
}

TEST_F(IntegrationNoteTest, CrashesOnDifferentEntriesAreNotInARow) {
  EndOn(7, SIGABRT);
  EndOn(8, SIGABRT);
  ExpectSuspect(8, 1);
}

TEST_F(IntegrationNoteTest, QuickKillSpeaksAgainstNoEntryHoweverOften) {
  for (int i = 0; i < 5; ++i) {
    EndOn(7, SIGKILL);
    EXPECT_FALSE(Open()->suspect().has_value());
  }
}

TEST_F(IntegrationNoteTest, KillBetweenTwoCrashesTakesNothingBack) {
  EndOn(7, SIGABRT);
  EndOn(7, SIGKILL);
  EndOn(7, SIGABRT);
  ExpectSuspect(7, 2);
}

TEST_F(IntegrationNoteTest, KillOfAnEntryThatHadTakenLongCounts) {
  const int ended_by = InChild([](IntegrationNote* note) {
    note->Begin(MapSequence(7));
    const auto now = std::chrono::steady_clock::now();
    IntegrationNote::AgeAll(now + std::chrono::milliseconds(IntegrationNote::kSuspiciousMs));
    ::raise(SIGKILL);
  });
  EXPECT_EQ(ended_by, SIGKILL);
  ExpectSuspect(7, 1);
}

TEST_F(IntegrationNoteTest, CrashBetweenEntriesOrOnAnotherThreadsWorkCountsNot) {
  EXPECT_EQ(InChild([](IntegrationNote* note) {
              note->Begin(MapSequence(7));
              note->End();
              std::abort();
            }),
            SIGABRT);
  EXPECT_FALSE(Open()->suspect().has_value());
}

TEST_F(IntegrationNoteTest, CrashOfAThreadThatHelpsCounts) {
  EXPECT_EQ(InChild([](IntegrationNote* note) {
              note->Begin(MapSequence(7));
              std::thread helper([owner = WorkOwner()] {
                SetWorkOwner(owner);
                ::raise(SIGSEGV);
              });
              helper.join();
            }),
            SIGSEGV);
  ExpectSuspect(7, 1);
}

TEST_F(IntegrationNoteTest, EndOfTheSuspectClearsIt) {
  EndOn(7, SIGABRT);
  const std::shared_ptr<IntegrationNote> note = Open();
  note->Begin(MapSequence(6));
  note->End();
  EXPECT_TRUE(note->suspect().has_value()) << "another entry must not clear it";
  note->Begin(MapSequence(7));
  note->End();
  EXPECT_FALSE(note->suspect().has_value());
  EXPECT_FALSE(Open()->suspect().has_value());
}

TEST_F(IntegrationNoteTest, FailureCountsAsACrashDoes) {
  EndOn(7, SIGABRT);
  const std::shared_ptr<IntegrationNote> note = Open();
  note->Begin(MapSequence(7));
  note->Fail();
  EXPECT_EQ(note->suspect()->crashes, 2U);
}

TEST_F(IntegrationNoteTest, HeadAndRevisionOutliveAKill) {
  EXPECT_EQ(InChild([](IntegrationNote* note) {
              note->NoteHead(MapSequence(40));
              note->NoteRevision(Revision(32));
              ::raise(SIGKILL);
            }),
            SIGKILL);
  EXPECT_EQ(Open()->known_head(), MapSequence(40));
  EXPECT_EQ(Open()->known_revision(), Revision(32));
}

TEST_F(IntegrationNoteTest, DamagedNoteIsMadeAnew) {
  EndOn(7, SIGABRT);
  for (const std::string& content : {std::string(), std::string("short"), std::string(4096, 'x')}) {
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << content;
    const std::shared_ptr<IntegrationNote> note = Open();
    EXPECT_FALSE(note->suspect().has_value());
    EXPECT_EQ(note->known_head(), MapSequence());
    note->NoteHead(MapSequence(3));
    EXPECT_EQ(Open()->known_head(), MapSequence(3)) << "and it works again";
  }
}

TEST_F(IntegrationNoteTest, FlippedBitOfTheNoteNeverMakesAHead) {
  Open()->NoteHead(MapSequence(40));
  const std::string whole = ContentOf(file_);
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    std::string damaged = whole;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << damaged;
    const MapSequence head = Open()->known_head();
    EXPECT_TRUE(head == MapSequence(40) || head == MapSequence()) << "bit " << bit;
  }
}

}  // namespace
}  // namespace steadymap

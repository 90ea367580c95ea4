// Tests the check of a damaged store, and the content that a salvage restores.

#include "server/store/repair/map_salvage.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/types/error.h"
#include "server/store/repair/store_check.h"
#include "tests/server/store/store_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::uint64_t kFrames = 12;
constexpr std::uint64_t kRevision = 6;

/// Two maps of twelve frames in files of two each, six of them integrated; tests damage the first.
class MapSalvageTest : public ::testing::Test {
 protected:
  void SetUp() override {
    options_.log_segment_bytes = 400;
    Open();
    for (const char* name : {"bad", "good"}) {
      const MapRecord map = store_->CreateMap(MakeMapRecord("acme", name)).value();
      ASSERT_TRUE(store_->LoadMap(map).ok());
      for (std::uint64_t frame = 1; frame <= kFrames; ++frame) {
        ASSERT_TRUE(store_->Append(MakeAppend(map.key, frame, 1)).ok());
      }
      const MapDelta delta = MakeDelta(0, kRevision, {MakeLeaf(0, 0, 0, 1)});
      ASSERT_TRUE(store_->CommitRevision(map.key, delta, MakeDetails(delta)).ok());
    }
    bad_ = store_->ListMaps()->front();
    store_.reset();
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "maps")) {
      if (std::stoull(entry.path().filename()) == bad_.key.value()) bad_folder_ = entry.path();
    }
  }

  void Open() {
    absl::StatusOr<std::unique_ptr<Store>> store = Store::Open(folder_.path(), options_);
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }

  std::vector<std::string> ProblemsOfBad() {
    const absl::StatusOr<StoreCheckResult> findings = CheckStore(folder_.path(), std::nullopt);
    EXPECT_TRUE(findings.ok()) << findings.status();
    if (!findings.ok()) return {};
    EXPECT_THAT(findings->maps.back().problems, IsEmpty());
    return findings->maps.front().problems;
  }

  SalvageReport Salvage(std::optional<MapSequence> skip_entry = {}) {
    const absl::StatusOr<SalvageReport> report =
        SalvageMap({folder_.path(), bad_.name, skip_entry, {}});
    EXPECT_TRUE(report.ok()) << report.status();
    return report.value_or(SalvageReport());
  }

  /// Opens the bad map like a server.
  absl::StatusOr<StoredState> LoadBad() {
    Open();
    return store_->LoadMap(store_->ListMaps()->front());
  }

  /// Returns the sequences of the changed entries; every sequence must exist.
  std::vector<std::uint64_t> ChangedEntries() {
    std::vector<std::uint64_t> changed;
    const std::vector<LogEntry> entries = ReadAll(store_.get(), bad_.key);
    EXPECT_EQ(entries.size(), kFrames);
    for (std::size_t i = 0; i < entries.size(); ++i) {
      EXPECT_EQ(entries[i].sequence, MapSequence(i + 1));
      if (SameEntry(entries[i], MakeLogEntry(i + 1))) continue;
      EXPECT_EQ(entries[i].kind, LogEntryKind::kSkipped);
      changed.push_back(i + 1);
    }
    return changed;
  }

  void ExpectNextAppendWorks() {
    EXPECT_TRUE(store_->Append(MakeAppend(bad_.key, kFrames + 1, 1)).ok());
    store_.reset();
    EXPECT_THAT(ProblemsOfBad(), IsEmpty());
  }

  static void Flip(const std::filesystem::path& file, std::uint64_t bit) {
    std::string bytes = ContentOf(file);
    bytes.at(bit / 8) = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
  }

  std::filesystem::path FileWithEntry(std::uint64_t sequence) const {
    const std::string frame = MakeLogEntry(sequence).packed_frame;
    for (const std::filesystem::path& file : LogFiles(bad_folder_ / "log")) {
      if (ContentOf(file).find(frame) != std::string::npos) return file;
    }
    return {};
  }

  /// Flips a bit of the payload of an entry.
  void DamageEntry(std::uint64_t sequence) {
    const std::filesystem::path file = FileWithEntry(sequence);
    Flip(file, 8 * ContentOf(file).find(MakeLogEntry(sequence).packed_frame) + 3);
  }

  void DamageDatabase() {
    for (const auto& entry : std::filesystem::directory_iterator(bad_folder_ / "state")) {
      if (entry.path().filename().string().starts_with("MANIFEST")) Flip(entry.path(), 300);
    }
  }

  /// Drops the integrated entries from the log, in whole files, so that the map's beginning is
  /// missing; returns the first remaining entry.
  std::uint64_t TrimLog() {
    EXPECT_TRUE(LoadBad().ok());
    TrimBounds bounds{kStoreTime, {}, {}, {}, /*disk_is_low=*/true};
    EXPECT_TRUE(store_->Trim(store_->ListMaps()->front(), bounds).ok());
    const std::vector<LogEntry> entries = ReadAll(store_.get(), bad_.key);
    store_.reset();
    EXPECT_FALSE(entries.empty());
    return entries.empty() ? 0 : entries.front().sequence.value();
  }

  /// Expects the entries from `first` on, each unchanged.
  void ExpectEntriesFrom(std::uint64_t first) {
    const std::vector<LogEntry> entries = ReadAll(store_.get(), bad_.key, first);
    ASSERT_EQ(entries.size(), kFrames + 1 - first);
    for (const LogEntry& entry : entries) {
      EXPECT_TRUE(SameEntry(entry, MakeLogEntry(entry.sequence.value())));
    }
  }

  TemporaryFolder folder_;
  StoreOptions options_;
  std::unique_ptr<Store> store_;
  MapRecord bad_;
  std::filesystem::path bad_folder_;
};

TEST_F(MapSalvageTest, CheckOfAWholeStoreFindsNothingAndChangesNothing) {
  std::vector<std::pair<std::string, std::string>> before;
  const auto files = [this] {
    std::vector<std::pair<std::string, std::string>> contents;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path())) {
      if (entry.is_regular_file()) contents.emplace_back(entry.path(), ContentOf(entry.path()));
    }
    std::sort(contents.begin(), contents.end());
    return contents;
  };
  before = files();
  const absl::StatusOr<StoreCheckResult> findings = CheckStore(folder_.path(), std::nullopt);
  ASSERT_TRUE(findings.ok()) << findings.status();
  EXPECT_TRUE(findings->ok());
  EXPECT_EQ(findings->maps.size(), 2U);
  EXPECT_EQ(files(), before);
}

TEST_F(MapSalvageTest, NeitherRunsBesideAServerNorWithoutAStoreOrMap) {
  Open();
  EXPECT_EQ(CheckStore(folder_.path(), std::nullopt).status().code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(SalvageMap({folder_.path(), bad_.name}).status().code(),
            absl::StatusCode::kFailedPrecondition);
  store_.reset();
  const MapName none{"acme", "none"};
  EXPECT_EQ(CheckStore(folder_.path(), none).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(SalvageMap({folder_.path(), none}).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(CheckStore(folder_.path() / "x", none).status().code(), absl::StatusCode::kNotFound);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "x"));
}

TEST_F(MapSalvageTest, DamagedEntryBehindTheRevisionIsTheOnlyOneThatIsLost) {
  DamageEntry(9);
  EXPECT_THAT(ProblemsOfBad(), Contains(HasSubstr(FileWithEntry(10).string())));
  EXPECT_EQ(LoadBad().status().code(), absl::StatusCode::kDataLoss);
  store_.reset();
  const SalvageReport report = Salvage();
  EXPECT_THAT(report.remarks, Contains(HasSubstr("entry 9 of the log is lost")));
  EXPECT_THAT(report.remarks, Contains(HasSubstr("robots: robot-1")));
  EXPECT_TRUE(std::filesystem::exists(report.old_files / "record")) << "nothing is deleted";
  EXPECT_THAT(ProblemsOfBad(), IsEmpty());
  const absl::StatusOr<StoredState> state = LoadBad();
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_EQ(state->snapshot.revision, Revision(kRevision));
  EXPECT_EQ(LeavesOf(state->snapshot).size(), 1U);
  EXPECT_EQ(store_->ListMaps()->front().incarnation, bad_.incarnation) << "the map is the same";
  EXPECT_EQ(ChangedEntries(), std::vector<std::uint64_t>{9});
  ExpectNextAppendWorks();
}

TEST_F(MapSalvageTest, DamagedDatabaseIsMadeAnewFromTheWholeLog) {
  DamageDatabase();
  EXPECT_THAT(ProblemsOfBad(), Contains(HasSubstr("state")));
  EXPECT_FALSE(LoadBad().ok());
  store_.reset();
  EXPECT_THAT(Salvage().remarks, Contains(HasSubstr("rebuilt from the log")));
  const absl::StatusOr<StoredState> state = LoadBad();
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_EQ(state->snapshot.revision, Revision(0));
  EXPECT_EQ(state->durable_head, MapSequence(kFrames));
  EXPECT_EQ(state->sessions.front().settled.contiguous_end(), ClientSequence(kFrames));
  EXPECT_NE(store_->ListMaps()->front().incarnation, bad_.incarnation);
  EXPECT_THAT(ChangedEntries(), IsEmpty());
  ExpectNextAppendWorks();
}

TEST_F(MapSalvageTest, DamagedDatabaseIsRepairedWhereTheLogBeginsLater) {
  const std::uint64_t first = TrimLog();
  ASSERT_GT(first, 1U);
  ASSERT_LE(first, kRevision + 1);
  DamageDatabase();
  EXPECT_FALSE(LoadBad().ok());
  store_.reset();
  EXPECT_THAT(Salvage().remarks, Contains(HasSubstr("was repaired and is at revision 6")));
  const absl::StatusOr<StoredState> state = LoadBad();
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_EQ(state->snapshot.revision, Revision(kRevision));
  EXPECT_EQ(LeavesOf(state->snapshot), std::vector<LeafChange>{MakeLeaf(0, 0, 0, 1)});
  EXPECT_EQ(state->durable_head, MapSequence(kFrames));
  EXPECT_NE(store_->ListMaps()->front().incarnation, bad_.incarnation) << "parts may be missing";
  ExpectEntriesFrom(kRevision + 1);
  ExpectNextAppendWorks();
}

TEST_F(MapSalvageTest, MapBeginsAnewWhereNeitherDatabaseNorLogTellItsBeginning) {
  const std::uint64_t first = TrimLog();
  ASSERT_GT(first, 1U);
  std::vector<std::filesystem::path> data;
  for (const auto& entry : std::filesystem::directory_iterator(bad_folder_ / "state")) {
    const std::string ending = entry.path().extension();
    if (ending == ".log" || ending == ".sst") data.push_back(entry.path());
  }
  ASSERT_FALSE(data.empty());
  for (const std::filesystem::path& file : data) std::filesystem::remove(file);
  EXPECT_FALSE(ProblemsOfBad().empty());
  EXPECT_FALSE(LoadBad().ok());
  store_.reset();
  EXPECT_THAT(
      Salvage().remarks,
      Contains(HasSubstr("the map is rebuilt starting with entry " + std::to_string(first))));
  const absl::StatusOr<StoredState> state = LoadBad();
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_EQ(state->snapshot.integrated(), MapSequence(first - 1));
  EXPECT_THAT(LeavesOf(state->snapshot), IsEmpty());
  EXPECT_EQ(state->durable_head, MapSequence(kFrames));
  EXPECT_NE(store_->ListMaps()->front().incarnation, bad_.incarnation);
  ExpectEntriesFrom(first);
  ExpectNextAppendWorks();
}

TEST_F(MapSalvageTest, MissingLogFilesAreFilledUp) {
  const std::filesystem::path missing = FileWithEntry(9);
  std::filesystem::remove(missing);
  EXPECT_THAT(ProblemsOfBad(), Contains(HasSubstr("begins with entry")));
  EXPECT_THAT(Salvage().remarks, Contains(HasSubstr("are missing")));
  ASSERT_TRUE(LoadBad().ok());
  EXPECT_THAT(ChangedEntries(), Contains(9U));
  ExpectNextAppendWorks();
}

TEST_F(MapSalvageTest, LostEndOfTheLogIsNoticedAndNamed) {
  // Only the note records an entry after the last commit, in a separate file.
  ASSERT_TRUE(LoadBad().ok());
  ASSERT_TRUE(store_->Append(MakeAppend(bad_.key, kFrames + 1, 1)).ok());
  store_.reset();
  std::filesystem::remove(FileWithEntry(kFrames + 1));
  EXPECT_THAT(ProblemsOfBad(), Contains(HasSubstr("files are missing, or older than the map")));
  EXPECT_EQ(LoadBad().status().code(), absl::StatusCode::kDataLoss);
  store_.reset();
  EXPECT_THAT(Salvage().remarks, Contains(HasSubstr("the entries 13 to 13 of the log are lost")));
  const absl::StatusOr<StoredState> state = LoadBad();
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_EQ(state->durable_head, MapSequence(kFrames));
  EXPECT_THAT(ChangedEntries(), IsEmpty());
  ExpectNextAppendWorks();
}

TEST_F(MapSalvageTest, SkippedEntryHasNoEffectAndTheOthersStay) {
  EXPECT_EQ(SalvageMap({folder_.path(), bad_.name, MapSequence(99)}).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_THAT(ProblemsOfBad(), IsEmpty()) << "a salvage that fails changes nothing";
  Salvage(MapSequence(8));
  ASSERT_TRUE(LoadBad().ok());
  EXPECT_EQ(ChangedEntries(), std::vector<std::uint64_t>{8});
  ExpectNextAppendWorks();
}

TEST_F(MapSalvageTest, OutputLeavesTheStoreAsItIs) {
  DamageEntry(9);
  const std::filesystem::path output = folder_.path() / "repaired";
  ASSERT_TRUE(SalvageMap({folder_.path(), bad_.name, {}, output}).ok());
  EXPECT_TRUE(std::filesystem::exists(output / "record"));
  EXPECT_FALSE(ProblemsOfBad().empty());
  EXPECT_EQ(SalvageMap({folder_.path(), bad_.name, {}, output}).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST_F(MapSalvageTest, WhateverBitIsFlippedTheMapComesBackWithAllThatCanBeRead) {
  const std::filesystem::path pristine = folder_.path().string() + "-pristine";
  std::filesystem::copy(folder_.path(), pristine, std::filesystem::copy_options::recursive);
  std::mt19937_64 random(5);
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(bad_folder_)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  int found = 0;
  for (const std::filesystem::path& file : files) {
    for (int flip = 0; flip < 2 && std::filesystem::file_size(file) > 0; ++flip) {
      const std::uint64_t bit = random() % (8 * std::filesystem::file_size(file));
      SCOPED_TRACE(file.string() + ", bit " + std::to_string(bit));
      Flip(file, bit);
      const bool is_found = !ProblemsOfBad().empty();
      found += is_found ? 1 : 0;
      EXPECT_TRUE(is_found || LoadBad().ok()) << "a check finds what keeps a map from opening";
      store_.reset();
      if (is_found) {
        Salvage();
        const absl::StatusOr<StoredState> state = LoadBad();
        ASSERT_TRUE(state.ok()) << state.status();
        EXPECT_EQ(state->durable_head, MapSequence(kFrames));
        EXPECT_LE(ChangedEntries().size(), 1U) << "one flip harms one entry";
        store_.reset();
        EXPECT_THAT(ProblemsOfBad(), IsEmpty());
      }
      std::filesystem::remove_all(folder_.path());
      std::filesystem::copy(pristine, folder_.path(), std::filesystem::copy_options::recursive);
    }
  }
  std::filesystem::remove_all(pristine);
  EXPECT_GT(found, 10) << "too few flips fell where they are noticed";
}

}  // namespace
}  // namespace steadymap

#include "core/map/object_library.h"

#include <algorithm>
#include <cassert>

namespace steadymap {

ObjectLibrary::Iterator::Iterator(const ObjectLibrary* library, std::size_t chunk, std::size_t slot)
    : library_(library), chunk_(chunk), slot_(slot) {
  SkipHoles();
}

void ObjectLibrary::Iterator::SkipHoles() {
  for (; chunk_ < library_->chunks_.size(); ++chunk_, slot_ = 0) {
    const Chunk& chunk = *library_->chunks_[chunk_].chunk;
    while (slot_ < kChunkIds && chunk.entries[slot_].second == nullptr) ++slot_;
    if (slot_ < kChunkIds) return;
  }
}

ObjectLibrary::Iterator::reference ObjectLibrary::Iterator::operator*() const {
  return library_->chunks_[chunk_].chunk->entries[slot_];
}

ObjectLibrary::Iterator& ObjectLibrary::Iterator::operator++() {
  ++slot_;
  SkipHoles();
  return *this;
}

ObjectLibrary::Iterator ObjectLibrary::Iterator::operator++(int) {
  Iterator before = *this;
  ++*this;
  return before;
}

std::size_t ObjectLibrary::PlaceOf(std::uint64_t number) const {
  const auto place = std::lower_bound(
      chunks_.begin(), chunks_.end(), number, [](const NumberedChunk& chunk, std::uint64_t asked) {
        return chunk.number < asked;
      });
  return static_cast<std::size_t>(place - chunks_.begin());
}

bool ObjectLibrary::HasChunk(std::size_t place, std::uint64_t number) const {
  return place < chunks_.size() && chunks_[place].number == number;
}

const ObjectLibrary::Entry* ObjectLibrary::FindEntry(ObjectId id) const {
  const std::size_t place = PlaceOf(NumberOf(id));
  if (!HasChunk(place, NumberOf(id))) return nullptr;
  const Entry& entry = chunks_[place].chunk->entries[SlotOf(id)];
  return entry.second == nullptr ? nullptr : &entry;
}

ObjectLibrary::Iterator ObjectLibrary::find(ObjectId id) const {
  if (!contains(id)) return end();
  return {this, PlaceOf(NumberOf(id)), SlotOf(id)};
}

ObjectLibrary::Iterator ObjectLibrary::upper_bound(ObjectId id) const {
  const std::size_t place = PlaceOf(NumberOf(id));
  return {this, place, HasChunk(place, NumberOf(id)) ? SlotOf(id) + 1 : 0};
}

const std::shared_ptr<const MapObject>& ObjectLibrary::at(ObjectId id) const {
  const Entry* entry = FindEntry(id);
  assert(entry != nullptr);
  return entry->second;
}

ObjectLibrary::Chunk& ObjectLibrary::MutableChunk(std::size_t place) {
  std::shared_ptr<Chunk>& chunk = chunks_[place].chunk;
  if (chunk.use_count() > 1) chunk = std::make_shared<Chunk>(*chunk);
  return *chunk;
}

void ObjectLibrary::insert_or_assign(ObjectId id, std::shared_ptr<const MapObject> object) {
  assert(object != nullptr);
  const std::size_t place = PlaceOf(NumberOf(id));
  if (!HasChunk(place, NumberOf(id))) {
    chunks_.insert(chunks_.begin() + static_cast<std::ptrdiff_t>(place),
                   {NumberOf(id), std::make_shared<Chunk>()});
  }
  Chunk& chunk = MutableChunk(place);
  Entry& entry = chunk.entries[SlotOf(id)];
  if (entry.second == nullptr) {
    ++chunk.count;
    ++size_;
  }
  entry = {id, std::move(object)};
}

void ObjectLibrary::erase(ObjectId id) {
  if (!contains(id)) return;
  const std::size_t place = PlaceOf(NumberOf(id));
  --size_;
  if (chunks_[place].chunk->count == 1) {
    chunks_.erase(chunks_.begin() + static_cast<std::ptrdiff_t>(place));
    return;
  }
  Chunk& chunk = MutableChunk(place);
  chunk.entries[SlotOf(id)] = {};
  --chunk.count;
}

void ObjectLibrary::ForEachDifference(
    const ObjectLibrary& before,
    const ObjectLibrary& after,
    const std::function<void(ObjectId, const MapObject* before, const MapObject* after)>& visit) {
  static const Chunk kNone{};
  auto older = before.chunks_.begin();
  auto newer = after.chunks_.begin();
  while (older != before.chunks_.end() || newer != after.chunks_.end()) {
    const bool has_older = older != before.chunks_.end() &&
                           (newer == after.chunks_.end() || older->number <= newer->number);
    const bool has_newer = newer != after.chunks_.end() &&
                           (older == before.chunks_.end() || newer->number <= older->number);
    const Chunk& old_chunk = has_older ? *older->chunk : kNone;
    const Chunk& new_chunk = has_newer ? *newer->chunk : kNone;
    if (has_older) ++older;
    if (has_newer) ++newer;
    if (&old_chunk == &new_chunk) continue;
    for (std::size_t slot = 0; slot < kChunkIds; ++slot) {
      const Entry& old_entry = old_chunk.entries[slot];
      const Entry& new_entry = new_chunk.entries[slot];
      if (old_entry.second == new_entry.second) continue;
      visit(old_entry.second != nullptr ? old_entry.first : new_entry.first,
            old_entry.second.get(),
            new_entry.second.get());
    }
  }
}

}  // namespace steadymap

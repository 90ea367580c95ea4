#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "core/map/map_object.h"
#include "core/types/identifiers.h"

namespace steadymap {

/// The objects of a map at one revision, by id; the part of `std::map` that the project uses.
///
/// Kept in chunks of consecutive ids. Copying shares the chunks; one that another copy shares is
/// cloned before it is written, so a published copy never changes (decisions.md 6), and a commit
/// costs what it changes. Iterators and references are valid until the next write.
class ObjectLibrary {
 public:
  /// An id and its object, which is never null.
  using Entry = std::pair<ObjectId, std::shared_ptr<const MapObject>>;

  /// Ids of a chunk, present or not. A commit copies a pointer for each chunk of the map and clones
  /// the chunks it changes: this many keep both small for thousands of objects.
  static constexpr std::size_t kChunkIds = 16;

  /// Goes through the entries by rising id.
  class Iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using value_type = Entry;
    using difference_type = std::ptrdiff_t;
    using pointer = const Entry*;
    using reference = const Entry&;

    Iterator() = default;

    reference operator*() const;

    pointer operator->() const { return &**this; }

    Iterator& operator++();
    Iterator operator++(int);

    friend bool operator==(const Iterator&, const Iterator&) = default;

   private:
    friend class ObjectLibrary;

    /// At the first entry at or behind a place.
    Iterator(const ObjectLibrary* library, std::size_t chunk, std::size_t slot);

    void SkipHoles();

    const ObjectLibrary* library_ = nullptr;
    std::size_t chunk_ = 0;  ///< Place in the list of chunks.
    std::size_t slot_ = 0;   ///< Place in the chunk; 0 at the end.
  };

  Iterator begin() const { return {this, 0, 0}; }

  Iterator end() const { return {this, chunks_.size(), 0}; }

  std::size_t size() const { return size_; }

  bool empty() const { return size_ == 0; }

  /// The end if there is no such object.
  Iterator find(ObjectId id) const;

  /// The first object with an id above this one, or the end.
  Iterator upper_bound(ObjectId id) const;

  bool contains(ObjectId id) const { return FindEntry(id) != nullptr; }

  /// The object of an id that is there (asserted).
  const std::shared_ptr<const MapObject>& at(ObjectId id) const;

  /// Puts an object, not null (asserted), into the place of its id.
  void insert_or_assign(ObjectId id, std::shared_ptr<const MapObject> object);

  /// Removes an object; no harm if there is none.
  void erase(ObjectId id);

  /// Calls `visit` by rising id for each object that the two libraries do not share; null stands
  /// for none. Cost: that of the chunks that they do not share.
  static void ForEachDifference(
      const ObjectLibrary& before,
      const ObjectLibrary& after,
      const std::function<void(ObjectId, const MapObject* before, const MapObject* after)>& visit);

 private:
  struct Chunk {
    std::array<Entry, kChunkIds> entries;  ///< By the low bits of the id; null objects are holes.
    std::size_t count = 0;                 ///< Of entries that are no holes; never 0 at rest.
  };

  struct NumberedChunk {
    std::uint64_t number = 0;  ///< Its ids over `kChunkIds`.
    std::shared_ptr<Chunk> chunk;
  };

  static std::uint64_t NumberOf(ObjectId id) { return id.value() / kChunkIds; }

  static std::size_t SlotOf(ObjectId id) { return id.value() % kChunkIds; }

  /// Place of the first chunk that is not before this number.
  std::size_t PlaceOf(std::uint64_t number) const;
  bool HasChunk(std::size_t place, std::uint64_t number) const;
  const Entry* FindEntry(ObjectId id) const;
  Chunk& MutableChunk(std::size_t place);

  std::vector<NumberedChunk> chunks_;  ///< By rising number.
  std::size_t size_ = 0;
};

}  // namespace steadymap

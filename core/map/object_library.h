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

/// The objects of a map at one revision, by id. Has the subset of the interface of `std::map` that
/// the project needs.
///
/// Objects are stored in chunks of consecutive ids. A copy shares the chunks. A chunk shared with
/// another copy is cloned before it is written, so a published copy never changes, and the cost of
/// a commit is proportional to its changes. Iterators and references are valid until the next
/// write.
class ObjectLibrary {
 public:
  /// An id and its object, which is never null.
  using Entry = std::pair<ObjectId, std::shared_ptr<const MapObject>>;

  /// Number of ids per chunk. A commit copies one pointer per chunk of the map and clones the
  /// changed chunks: this size keeps both costs low for thousands of objects.
  static constexpr std::size_t kChunkIds = 16;

  /// Iterates over the entries by increasing id.
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

    /// Points to the first entry at or after a position.
    Iterator(const ObjectLibrary* library, std::size_t chunk, std::size_t slot);

    void SkipHoles();

    const ObjectLibrary* library_ = nullptr;
    std::size_t chunk_ = 0;  ///< Index in the list of chunks.
    std::size_t slot_ = 0;   ///< Index in the chunk; 0 at the end.
  };

  Iterator begin() const { return {this, 0, 0}; }

  Iterator end() const { return {this, chunks_.size(), 0}; }

  std::size_t size() const { return size_; }

  bool empty() const { return size_ == 0; }

  /// Returns the end if the object does not exist.
  Iterator find(ObjectId id) const;

  /// Returns the first object with an id above `id`, or the end.
  Iterator upper_bound(ObjectId id) const;

  bool contains(ObjectId id) const { return FindEntry(id) != nullptr; }

  /// Returns the object of an existing id (asserted).
  const std::shared_ptr<const MapObject>& at(ObjectId id) const;

  /// Inserts or replaces an object, not null (asserted).
  void insert_or_assign(ObjectId id, std::shared_ptr<const MapObject> object);

  /// Removes an object. No effect if it does not exist.
  void erase(ObjectId id);

  /// Calls `visit` by increasing id for each object that is not shared by the two libraries; null
  /// if it does not exist in one of them. Cost: proportional to the chunks that are not shared.
  static void ForEachDifference(
      const ObjectLibrary& before,
      const ObjectLibrary& after,
      const std::function<void(ObjectId, const MapObject* before, const MapObject* after)>& visit);

 private:
  struct Chunk {
    std::array<Entry, kChunkIds> entries;  ///< By low bits of the id; null object: unused.
    std::size_t count = 0;                 ///< Number of used entries; never 0 between calls.
  };

  struct NumberedChunk {
    std::uint64_t number = 0;  ///< Common quotient of its ids and `kChunkIds`.
    std::shared_ptr<Chunk> chunk;
  };

  static std::uint64_t NumberOf(ObjectId id) { return id.value() / kChunkIds; }

  static std::size_t SlotOf(ObjectId id) { return id.value() % kChunkIds; }

  /// Returns the index of the first chunk with at least this number.
  std::size_t PlaceOf(std::uint64_t number) const;
  bool HasChunk(std::size_t place, std::uint64_t number) const;
  const Entry* FindEntry(ObjectId id) const;
  Chunk& MutableChunk(std::size_t place);

  std::vector<NumberedChunk> chunks_;  ///< By increasing number.
  std::size_t size_ = 0;
};

}  // namespace steadymap

#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <optional>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

namespace steadymap {

/// The bound on the memory of frames under way, from before they are decoded until they are
/// integrated: so many bytes a map, and so many for all maps together. Who asks for more waits its
/// turn; those of one map in the order they asked, so robots share a busy map fairly.
///
/// One frame larger than a limit is let in alone, so that it cannot wait for ever.
/// Thread-safe. Outlived by its accounts and reservations.
class FrameBudget {
  struct State;

 public:
  /// The share of one map.
  class Account;

  /// Bytes that are taken; gives them back when it is destroyed.
  class Reservation {
   public:
    Reservation() = default;
    Reservation(Reservation&& other) noexcept;
    Reservation& operator=(Reservation&& other) noexcept;
    ~Reservation();

    std::size_t bytes() const { return bytes_; }

   private:
    friend class FrameBudget;
    Reservation(std::shared_ptr<Account> account, std::size_t bytes);
    void Release();

    std::shared_ptr<Account> account_;
    std::size_t bytes_ = 0;
  };

  /// Takes the reservation that was waited for. It may be called from any thread that gives bytes
  /// back, so it hands its work on.
  using Grant = std::function<void(Reservation)>;

  explicit FrameBudget(std::size_t total_bytes);

  /// A map's share of at most `max_bytes`.
  std::shared_ptr<Account> OpenAccount(std::size_t max_bytes);

  /// Takes `bytes` if they are free and nobody of the map waits for some.
  static std::optional<Reservation> TryReserve(const std::shared_ptr<Account>& account,
                                               std::size_t bytes);

  /// Takes `bytes` now or as soon as they are free, and calls `grant` once, maybe before it
  /// returns. A grant that is still waiting when its account is closed is dropped.
  static void Reserve(const std::shared_ptr<Account>& account, std::size_t bytes, Grant grant);

  /// Drops who waits for bytes of the account.
  static void Close(const std::shared_ptr<Account>& account);

  /// New limits; what is taken stays taken.
  void SetTotal(std::size_t total_bytes);
  static void SetMax(const std::shared_ptr<Account>& account, std::size_t max_bytes);

  /// Bytes that are taken.
  std::size_t used_bytes() const;

 private:
  struct Waiter {
    std::shared_ptr<Account> account;
    std::size_t bytes = 0;
    Grant grant;
  };

  /// What accounts share; outlives the budget as long as one of them does.
  struct State {
    bool Fits(const Account& account, std::size_t bytes) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex);
    bool Waits(const Account& account) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex);
    void Take(Account& account, std::size_t bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex);

    /// Takes bytes for those who can have them now; the caller calls their grants.
    std::list<Waiter> TakeForWaiters() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex);

    mutable absl::Mutex mutex;
    std::size_t max_bytes ABSL_GUARDED_BY(mutex) = 0;
    std::size_t used_bytes ABSL_GUARDED_BY(mutex) = 0;
    std::list<Waiter> waiters ABSL_GUARDED_BY(mutex);
  };

  static void GrantAll(std::list<Waiter> granted);

  std::shared_ptr<State> state_;
};

/// Opaque to everybody but the budget.
class FrameBudget::Account {
 private:
  friend class FrameBudget;
  friend struct FrameBudget::State;

  std::shared_ptr<State> state_;
  std::size_t max_bytes_ = 0;   ///< Guarded by the state's mutex.
  std::size_t used_bytes_ = 0;  ///< Guarded by the state's mutex.
};

}  // namespace steadymap

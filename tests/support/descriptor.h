#pragma once

#include <cerrno>
#include <system_error>
#include <utility>

#include <unistd.h>

namespace steadymap {

/// A file descriptor, closed by the destructor. Movable; empty after a move.
class Descriptor {
 public:
  Descriptor() = default;

  /// Takes the result of a system call; throws `std::system_error` with `errno` if it failed.
  explicit Descriptor(int number) : number_(number) {
    if (number_ < 0) throw std::system_error(errno, std::generic_category(), "file descriptor");
  }

  ~Descriptor() { Close(); }

  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}

  Descriptor& operator=(Descriptor&& other) noexcept {
    if (this == &other) return *this;
    Close();
    number_ = std::exchange(other.number_, -1);
    return *this;
  }

  /// -1 if empty.
  int number() const { return number_; }

  void Close() {
    if (number_ >= 0) close(number_);
    number_ = -1;
  }

 private:
  int number_ = -1;
};

}  // namespace steadymap

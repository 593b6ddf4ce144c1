// A mailbox of a simulated program: messages wait until it runs; what does not fit is lost. Pure.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

namespace rack::drives {

template <typename Data>
class Mailbox {
 public:
  explicit Mailbox(std::size_t slots) : slots_(slots) {}

  void put(const Data& data) {
    if (waiting_.size() < slots_) waiting_.push_back(data);
  }
  std::optional<Data> take() {
    if (waiting_.empty()) return std::nullopt;
    Data first = std::move(waiting_.front());
    waiting_.pop_front();
    return first;
  }
  std::optional<Data> take_newest() {
    std::optional<Data> newest;
    while (auto next = take()) newest = std::move(next);
    return newest;
  }
  void clear() { waiting_.clear(); }

 private:
  std::size_t slots_;
  std::deque<Data> waiting_;
};

}  // namespace rack::drives

// Tells whoever watches a thread that it waits for a message: a wait that is meant.
#pragma once

namespace tims::os {

class WaitObserver {
 public:
  virtual ~WaitObserver() = default;
  virtual void begins() = 0;
  virtual void ends() = 0;
};

// Of this thread; null: nobody.
inline thread_local WaitObserver* wait_observer = nullptr;

class Waiting {
 public:
  Waiting() : observer_(wait_observer) {
    if (observer_ != nullptr) observer_->begins();
  }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;
  ~Waiting() {
    if (observer_ != nullptr) observer_->ends();
  }

 private:
  WaitObserver* const observer_;
};

}  // namespace tims::os

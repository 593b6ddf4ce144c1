// Who watches a thread learns when it waits for a message: a wait that is meant. A detector of
// threads that are kept waiting where they must not be is told so.
#pragma once

#include "tims/export.h"

namespace tims {

class WaitObserver {
 public:
  virtual ~WaitObserver() = default;
  virtual void begins() = 0;
  virtual void ends() = 0;
};

// Of the calling thread; null: nobody.
TIMS_API void set_wait_observer(WaitObserver* observer);
TIMS_API WaitObserver* wait_observer();

// A wait of this thread, from here to the end of the scope. Mailboxes wait like this.
class Waiting {
 public:
  Waiting() : observer_(wait_observer()) {
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

}  // namespace tims

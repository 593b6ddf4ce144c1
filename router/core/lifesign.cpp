#include "router/core/lifesign.h"

#include <algorithm>

namespace tims::core {

void Lifesigns::set_interval(Time now, Duration interval) {
  interval_ = interval;
  next_ = std::min(next_, now + interval);
}

void Lifesigns::watch(Time now, Client& client) {
  client.owes_answer = false;
  if (client.watched) return;
  client.watched = true;
  if (watched_++ == 0) next_ = now + interval_;
}

void Lifesigns::unwatch(Client& client) {
  client.owes_answer = false;
  if (!client.watched) return;
  client.watched = false;
  --watched_;
}

Lifesigns::Beat Lifesigns::beat(Time now) {
  if (now < next_beat()) return Beat::kNotYet;
  const bool late = now - next_ > interval_ / 2;
  next_ = late ? now + interval_ : next_ + interval_;
  return late ? Beat::kLate : Beat::kAsk;
}

}  // namespace tims::core

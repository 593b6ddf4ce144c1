// The way to one router: what waits for it, and the writer that takes it.
#pragma once

#include <memory>

#include "router/io/dds/orders.h"
#include "router/io/dds/send_queue.h"
#include "router/io/dds/writer.h"
#include "tims/time.h"

namespace tims::io {

class DdsRoute {
 public:
  struct Counters {
    std::uint64_t samples = 0;
    std::uint64_t bytes = 0;  // of datagrams
    std::uint64_t datagrams = 0;
    std::uint64_t unmatched = 0;  // datagrams thrown away: the receiver did not appear
  };

  // `heartbeat`: how soon the other is asked what it has got. The longer nothing comes from it, the
  // more seldom, whatever else is written meanwhile: who is slow since its host is busy gets no
  // more to do that way, and many who wait for each other do not keep each other waiting.
  DdsRoute(const link::NetAddress& to, Duration heartbeat)
      : peer_(std::make_shared<DdsPeer>(to)), heartbeat_(heartbeat) {}

  // What the engine's thread makes a writer for.
  [[nodiscard]] const std::shared_ptr<DdsPeer>& peer() const { return peer_; }
  // None: until there is another one, all waits.
  void set_writer(DdsWriter* writer) {
    writer_ = writer;
    ask_at_ = silent_since_ = kNever;
    again_at_ = {};
  }

  // False when there is no room.
  bool put(const link::Train& train) { return queue_.put(train); }
  // Writes one sample of what waits, if it can: then others have their turn. When to call again;
  // earlier if something has happened. Throws what the library throws.
  Time serve(Time now, Counters& counters);
  // Something has come from there, perhaps an acknowledgement: a full history may have room.
  void on_heard(Time now);

  // Until the next question or try, when nothing has come for so long: twice as long each time.
  static Duration pause(Duration silent, Duration least);

  [[nodiscard]] std::size_t waiting_bytes() const { return queue_.waiting_bytes(); }
  // Whether nothing is on its way.
  [[nodiscard]] bool is_finished() {
    return waiting_bytes() == 0 && (!writer_ || writer_->has_arrived());
  }

 private:
  Time write_next(Time now, Counters& counters);
  Time ask(Time now);
  Time wait_for_reader(Time now, Counters& counters);
  Time next_ask(Time now);
  Duration silence(Time now);

  std::shared_ptr<DdsPeer> peer_;
  SendQueue queue_;
  DdsWriter* writer_ = nullptr;
  Time waits_since_ = kNever;   // for the reader
  Duration answers_in_{};       // how long it takes to answer, of late
  Time silent_since_ = kNever;  // the other, as far as it was asked or is waited for
  Time again_at_{};             // with a full history: each try costs a copy
  const Duration heartbeat_;
  Time ask_at_ = kNever;
};

}  // namespace tims::io

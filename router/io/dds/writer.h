// What is sent to one router: a bounded queue of datagrams, the writer that takes them as samples
// of many datagrams each, and the route that decides when a sample is written and when the other is
// asked what it has got. One writer for each router, in a partition that only that router reads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include "router/io/dds/dds_engine.h"
#include "router/io/dds/discovery_filter.h"
#include "router/io/dds/events.h"
#include "router/link/transport.h"
#include "tims/time.h"

namespace tims::io {

// What the library answers when it cannot make something: std::runtime_error for nullptr.
template <typename T>
T* require(T* made, const char* what) {
  if (made == nullptr) throw std::runtime_error(std::string("no ") + what + " could be made");
  return made;
}

// --- samples: octets that mean nothing to DDS, without a copy more than needed

inline constexpr std::size_t kSampleBytesMax = 65'000;

// What is written: both parts, one behind the other.
struct OctetsOut {
  std::array<std::span<const std::byte>, 2> parts{};
};

// What is taken; the memory is used again.
class OctetsIn {
 public:
  [[nodiscard]] std::span<std::byte> bytes() { return {memory_.get(), size_}; }
  // Longer ones than we write are empty: nobody understands them.
  void assign(std::span<const std::byte> bytes);

 private:
  std::unique_ptr<std::byte[]> memory_;
  std::size_t size_ = 0;
};

class OctetsType final : public eprosima::fastdds::dds::TopicDataType {
 public:
  static constexpr const char* kName = "tims::octets";

  OctetsType();
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override;
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override;
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override;
  void* createData() override { return new OctetsIn; }
  void deleteData(void* data) override { delete static_cast<OctetsIn*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
  [[nodiscard]] bool is_bounded() const override { return false; }
};

// What waits to be written to one router: datagrams in a ring of bytes, in the form they have in a
// sample (link/transport.h: Batch), so that a sample is a piece of the ring.
class SendQueue {
 public:
  static constexpr std::size_t kBytes = 4 << 20;  // allocated with the first burst

  explicit SendQueue(std::size_t bytes = kBytes) : size_(bytes) {}

  // All of the burst, or nothing: false when there is no room for it.
  bool put(const link::Burst& burst);

  // Whole datagrams from the front, `bytes_max` at most, or the first one if it is larger.
  struct Front {
    std::array<std::span<const std::byte>, 2> parts{};  // the second: from the ring's beginning on
    std::size_t bytes = 0;
    std::size_t datagrams = 0;
  };
  // It stays as it is until remove().
  [[nodiscard]] Front front(std::size_t bytes_max) const;
  void remove(const Front& front);

  [[nodiscard]] std::size_t waiting_bytes() const { return used_; }

 private:
  void write(std::span<const std::byte> bytes);
  [[nodiscard]] std::size_t datagram_size_at(std::size_t position) const;

  const std::size_t size_;
  std::unique_ptr<std::byte[]> ring_;
  std::size_t used_ = 0;
  std::size_t first_ = 0;  // the oldest byte
  std::size_t end_ = 0;    // where the next one goes
};

enum class Written : std::uint8_t {
  kYes,
  kNotNow,  // the history is full of what the reader has not acknowledged
  kNever,
};

// A writer that reaches one router only. Made and ended by the engine's thread, used by the loop.
class DdsWriter {
 public:
  struct Place {
    eprosima::fastdds::dds::DomainParticipant& participant;
    eprosima::fastdds::dds::Topic& topic;
    const DdsSettings& settings;
  };

  // Throws std::runtime_error when the library does not make it.
  DdsWriter(const Place& place, std::shared_ptr<DdsPeer> peer, std::shared_ptr<DdsEvents> events,
            std::shared_ptr<UserTraffic> traffic);
  DdsWriter(const DdsWriter&) = delete;
  DdsWriter& operator=(const DdsWriter&) = delete;
  ~DdsWriter();

  // May throw what the library throws. The bytes are copied.
  Written write(const OctetsOut& sample);
  // Whether all that was written has been acknowledged.
  [[nodiscard]] bool has_arrived();
  // Asks the reader what it has got: what it lacks is sent again. Nothing where the library does
  // that, as a profile says.
  void ask();

 private:
  class Match;

  eprosima::fastdds::dds::DomainParticipant& participant_;
  const std::shared_ptr<UserTraffic> traffic_;
  std::unique_ptr<Match> match_;
  eprosima::fastdds::dds::Publisher* publisher_ = nullptr;
  eprosima::fastdds::dds::DataWriter* writer_ = nullptr;
  bool asks_ = false;
  RtpsHeartbeat heartbeat_{};
  const std::uint32_t history_;
  std::vector<link::NetAddress> to_{};
};

// The way to one router: what waits for it, and the writer that takes it.
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
  bool put(const link::Burst& burst) { return queue_.put(burst); }
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

// Sending to one router: a bounded queue of datagrams, the writer that sends them as samples of
// many datagrams each, and the route, which decides when to write a sample and when to send a
// heartbeat. One writer for each router, in a partition that only that router reads.
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

// Converts a null pointer returned by the library to std::runtime_error.
template <typename T>
T* require(T* made, const char* what) {
  if (made == nullptr) throw std::runtime_error(std::string("no ") + what + " could be made");
  return made;
}

// --- samples: octets without meaning for DDS, copied no more than necessary

inline constexpr std::size_t kSampleBytesMax = 65'000;

// A sample to be written: both parts, concatenated.
struct OctetsOut {
  std::array<std::span<const std::byte>, 2> parts{};
};

// A received sample; the memory is reused.
class OctetsIn {
 public:
  [[nodiscard]] std::span<std::byte> bytes() { return {memory_.get(), size_}; }
  // Samples longer than ours are stored as empty, because they cannot be valid.
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

// Datagrams waiting to be written to one router: a ring of bytes, in the encoding of a sample
// (link/transport.h: Batch), so that a sample is a contiguous part of the ring.
class SendQueue {
 public:
  static constexpr std::size_t kBytes = 4 << 20;  // allocated with the first burst

  explicit SendQueue(std::size_t bytes = kBytes) : size_(bytes) {}

  // Stores the whole burst or nothing: returns false when there is no room.
  bool put(const link::Burst& burst);

  // Whole datagrams from the front, at most `bytes_max`, or the first one if it is larger.
  struct Front {
    // The second part starts at the beginning of the ring.
    std::array<std::span<const std::byte>, 2> parts{};
    std::size_t bytes = 0;
    std::size_t datagrams = 0;
  };
  // Valid until remove().
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
  std::size_t end_ = 0;    // position of the next byte to be stored
};

enum class Written : std::uint8_t {
  kYes,
  kNotNow,  // the history is full of unacknowledged samples
  kNever,
};

// A writer that reaches one router only. Created and destroyed by the engine's thread, used by
// the loop.
class DdsWriter {
 public:
  struct Place {
    eprosima::fastdds::dds::DomainParticipant& participant;
    eprosima::fastdds::dds::Topic& topic;
    const DdsSettings& settings;
  };

  // Throws std::runtime_error when the library cannot create it.
  DdsWriter(const Place& place, std::shared_ptr<DdsPeer> peer, std::shared_ptr<DdsEvents> events,
            std::shared_ptr<UserTraffic> traffic);
  DdsWriter(const DdsWriter&) = delete;
  DdsWriter& operator=(const DdsWriter&) = delete;
  ~DdsWriter();

  // May throw exceptions of the library. The bytes are copied.
  Written write(const OctetsOut& sample);
  // True when all written samples have been acknowledged.
  [[nodiscard]] bool has_arrived();
  // Sends a heartbeat to the reader, so that lost samples are requested again. Does nothing when
  // a profile leaves heartbeats to the library.
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

// The route to one router: its queue, and the writer that sends it.
class DdsRoute {
 public:
  struct Counters {
    std::uint64_t samples = 0;
    std::uint64_t bytes = 0;  // of datagrams
    std::uint64_t datagrams = 0;
    std::uint64_t unmatched = 0;  // datagrams dropped because the receiver did not appear
  };

  // `heartbeat`: initial interval of heartbeats. The interval grows while the router is silent,
  // whatever else is written: a router that is slow because its host is busy gets no additional
  // work, and many waiting routers do not delay each other.
  DdsRoute(const link::NetAddress& to, Duration heartbeat)
      : peer_(std::make_shared<DdsPeer>(to)), heartbeat_(heartbeat) {}

  // The peer for which the engine's thread creates a writer.
  [[nodiscard]] const std::shared_ptr<DdsPeer>& peer() const { return peer_; }
  // Null: everything waits until there is another one.
  void set_writer(DdsWriter* writer) {
    writer_ = writer;
    heartbeat_at_ = silent_since_ = kNever;
    again_at_ = {};
  }

  // Returns false when there is no room.
  bool put(const link::Burst& burst) { return queue_.put(burst); }
  // Writes one sample from the queue, if possible, then lets others have their turn. Returns the
  // time of the next call; call earlier after an event. Throws exceptions of the library.
  Time serve(Time now, Counters& counters);
  // Something was received from the router, perhaps an acknowledgement: a full history may have
  // room.
  void on_received(Time now);

  // The time until the next heartbeat or attempt after this period of silence: doubled each time.
  static Duration pause(Duration silent, Duration least);

  [[nodiscard]] std::size_t waiting_bytes() const { return queue_.waiting_bytes(); }
  // True when nothing is in flight.
  [[nodiscard]] bool is_finished() {
    return waiting_bytes() == 0 && (!writer_ || writer_->has_arrived());
  }

 private:
  Time write_next(Time now, Counters& counters);
  Time ask(Time now);
  Time wait_for_reader(Time now, Counters& counters);
  Time next_heartbeat(Time now);
  Duration silence(Time now);

  std::shared_ptr<DdsPeer> peer_;
  SendQueue queue_;
  DdsWriter* writer_ = nullptr;
  Time waits_since_ = kNever;  // waiting for the reader
  Duration answers_in_{};      // recent answering time
  // Start of the router's silence, while an answer or acknowledgement is expected.
  Time silent_since_ = kNever;
  Time again_at_{};  // with a full history: each attempt costs a copy
  const Duration heartbeat_;
  Time heartbeat_at_ = kNever;
};

}  // namespace tims::io

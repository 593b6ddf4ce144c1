// The type of our topic, by hand: octets that mean nothing to DDS, without a copy more than needed.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>

#include <fastdds/dds/topic/TopicDataType.hpp>

namespace tims::io {

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

}  // namespace tims::io

// A component that produces data: its data sets are kept for a while, sent to listeners, and can be
// requested by their time (specification, section 6).
//
//   class Scanner : public rack::DataModule<rack::LadarData> {
//     Result<void> module_loop() override {
//       rack::LadarData& scan = get_local_buffer();
//       ...                                  // recordingTime is the first field
//       return put_local_buffer();           // stores and sends it
//     }
//   };
#pragma once

#include <memory>
#include <variant>
#include <vector>

#include "rack/data_history.h"
#include "rack/module.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

struct DataInfo {
  std::uint32_t history = 10;    // number of data sets that can be requested
  std::size_t size_max = 0;      // maximum size of a body, bytes
  std::uint32_t listeners = 64;  // maximum number
  // A newer data set replaces an older one: links short of bandwidth may skip the older.
  bool samples = true;
};

// The part that does not depend on the struct.
class DataModuleBase : public Module {
 public:
  DataModuleBase(const ModuleInfo& info, const DataInfo& data);
  ~DataModuleBase() override;

 protected:
  Result<void> module_command(const tims::MessageView& message) override;
  // Calls module_loop() until there are data, so that data can be requested as soon as the
  // component is on.
  Result<void> module_on() override;

  // The period of the data, ms. Call it in module_on(), before DataModule::module_on(). With 0 the
  // component cannot be turned on.
  void set_period(std::chrono::milliseconds period);
  [[nodiscard]] std::chrono::milliseconds period() const;

  std::span<std::byte> workspace() { return history_.workspace(); }
  void publish(TimeStamp recorded, std::size_t size);

  // Writes the data set of a requested time to `to` and returns its size. By default the nearest; a
  // component may interpolate. Called with mutex_ held.
  virtual Result<std::size_t> data_at(TimeStamp time, std::span<std::byte> to) const;
  [[nodiscard]] const DataHistory& history() const { return history_; }
  [[nodiscard]] tims::Error no_data() const;
  static tims::Error not_there(DataHistory::Miss miss, TimeStamp time);

 private:
  void turned_off() override;
  [[nodiscard]] bool has_data() const override { return true; }

  class [[gnu::visibility("hidden")]] Publisher;  // sends the data to listeners

  const DataInfo data_;
  DataHistory history_;  // protected by mutex_, except the workspace of the data task
  std::unique_ptr<Publisher> publisher_;
};

template <Struct Data>
class DataModule : public DataModuleBase {
 public:
  DataModule(const ModuleInfo& info, const DataInfo& data) : DataModuleBase(info, with_size(data)) {
    reserve_all(local_buffer_);
  }

 protected:
  // The data task builds the next data set here; the contents of the last one are kept.
  Data& get_local_buffer() { return local_buffer_; }
  // kInvalidArgument: the data set cannot be encoded, or is larger than DataInfo::size_max.
  Result<void> put_local_buffer() {
    const auto size = encode(local_buffer_, workspace());
    if (!size) return size.error();
    publish(local_buffer_.recordingTime, *size);
    return {};
  }

  // For a data_at() that interpolates: calls `between` with the data sets before and after `time`.
  // Up to `ahead` after the newest, these are the newest two.
  using Between = Data (*)(const Data& before, const Data& after, TimeStamp time);
  Result<std::size_t> data_between(TimeStamp time, std::chrono::milliseconds ahead,
                                   std::span<std::byte> to, Between between) const {
    const auto found = history().around(time, ahead);
    if (const auto* miss = std::get_if<DataHistory::Miss>(&found)) return not_there(*miss, time);
    const auto& pair = std::get<DataHistory::Pair>(found);
    const auto before = decode<Data>(pair.before.body);
    const auto after = decode<Data>(pair.after.body);
    if (!before) return before.error();
    if (!after) return after.error();
    return encode(between(*before, *after, time), to);
  }
  // The same without extrapolation: after the newest, the answer is the newest, as by default. For
  // data that may jump or stop.
  Result<std::size_t> data_between(TimeStamp time, std::span<std::byte> to, Between between) const {
    if (time - history().newest().recorded >= std::chrono::milliseconds(0))
      return DataModuleBase::data_at(time, to);
    return data_between(time, {}, to, between);
  }

 private:
  static DataInfo with_size(DataInfo data) {
    if (data.size_max == 0) data.size_max = body_max<Data>();
    return data;
  }
  Data local_buffer_{};
};

}  // namespace rack

#pragma GCC visibility pop

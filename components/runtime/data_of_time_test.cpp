#include "rack/data_of_time.h"

#include <vector>

#include <gtest/gtest.h>

namespace rack {
namespace data_of_time_test {

using namespace std::chrono_literals;

// A partner whose newest data are later and later.
class LateProxy {
 public:
  struct Data {
    TimeStamp recordingTime = 0;
  };
  explicit LateProxy(std::vector<std::uint32_t> times) : times_(std::move(times)) {}

  tims::Result<void> get_data(Data& data, TimeStamp time = 0) {
    ++asked;
    data.recordingTime = time.raw() == 0 ? newest() : time;
    if (data.recordingTime - newest() <= 0ms) return {};
    ++refused;
    return tims::Error(tims::Errc::kAnsweredError, "not available yet");
  }
  tims::Result<void> get_next_data(Data& data, tims::Duration timeout) {
    EXPECT_GT(timeout, tims::Duration(0));
    ++waited;
    if (at_ + 1 == times_.size()) return tims::Error(tims::Errc::kTimeout, "nothing comes");
    data.recordingTime = times_[++at_];
    return {};
  }

  int asked = 0;
  int refused = 0;
  int waited = 0;

 private:
  [[nodiscard]] TimeStamp newest() const { return times_[at_]; }

  std::vector<std::uint32_t> times_;
  std::size_t at_ = 0;
};

TEST(DataOfTime, WaitsInsteadOfBeingRefused) {
  LateProxy proxy({100, 200, 300, 400});
  DataOfTime<LateProxy> then;
  LateProxy::Data data;
  ASSERT_TRUE(then.get(proxy, data, 250, 1min));
  EXPECT_EQ(data.recordingTime, TimeStamp(250));
  EXPECT_EQ(proxy.waited, 2);
  ASSERT_TRUE(then.get(proxy, data, 300, 1min));
  EXPECT_EQ(proxy.waited, 2) << "it is known to have these";
  EXPECT_EQ(proxy.asked, 3);
  EXPECT_EQ(proxy.refused, 0);
}

TEST(DataOfTime, TimesWrap) {
  LateProxy proxy({0xFFFFFFF0, 10, 20});
  DataOfTime<LateProxy> then;
  LateProxy::Data data;
  ASSERT_TRUE(then.get(proxy, data, 15, 1min));
  EXPECT_EQ(data.recordingTime, TimeStamp(15));
  EXPECT_EQ(proxy.waited, 2);
  EXPECT_EQ(proxy.refused, 0);
}

TEST(DataOfTime, GivesUpWithoutAskingForWhatIsNotThere) {
  LateProxy proxy({100, 200});
  DataOfTime<LateProxy> then;
  LateProxy::Data data;
  EXPECT_EQ(then.get(proxy, data, 250, 1min).error().code(), tims::Errc::kTimeout);
  EXPECT_EQ(then.get(proxy, data, 250, 0ms).error().code(), tims::Errc::kTimeout);
  EXPECT_EQ(proxy.waited, 2) << "no patience, no wait";
  EXPECT_EQ(proxy.refused, 0);
  ASSERT_TRUE(then.get(proxy, data, 200, 0ms));
}

}  // namespace data_of_time_test
}  // namespace rack

// Any request is answered with one JSON object of bounded size.
#include <boost/json.hpp>

#include "router/io/linked_fixture.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  fuzz::Input input(data, size);
  // Created once, because no request changes it.
  static const io::test::LinkedFixture router;
  const std::string answer =
      io::answer_admin(input.text(), router, io::test::LinkedFixture::clocks());
  fuzz::require(answer.size() <= io::kAnswerBytesMax);
  boost::system::error_code error;
  const boost::json::value json = boost::json::parse(answer, error);
  fuzz::require(!error && json.is_object());
  return 0;
}

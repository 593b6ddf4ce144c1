#include "tools/timsctl/recognised_picture.h"

#include <algorithm>
#include <deque>

#include <fmt/format.h>

#include "os/clock.h"

namespace timsctl {

namespace {

constexpr std::size_t kPicturesMax = 32;

template <typename Data>
Data data_of(ComponentClient& client, tims::Address component, std::int8_t request) {
  const std::string name = client.name_of(component);
  const Message answer = client.ask(component, request, rack::GetDataRequest{});
  if (answer.header.type != tims::type::kData)
    throw Failure(Exit::kNo, "no_data", name + " has no data", "timsctl component on " + name);
  return value_or_fail(rack::decode<Data>(answer.view()), name);
}

// By this, its times are before those of the camera.
std::chrono::milliseconds lag_of(ComponentClient& client, tims::Address recogniser) {
  const rack::ParameterList list = client.parameters(recogniser);
  const auto lag = std::ranges::find_if(list.parameters, [](const rack::Parameter& parameter) {
    return parameter.name.view() == "cameraLag";
  });
  return std::chrono::milliseconds(lag == list.parameters.end() ? 0 : lag->valueInt);
}

}  // namespace

RecognisedPicture recognised_picture(ComponentClient& client, tims::Address camera,
                                     tims::Address recogniser, tims::Duration patience) {
  const std::chrono::milliseconds lag = lag_of(client, recogniser);
  std::deque<rack::CameraData> pictures;
  for (const auto end = tims::os::deadline_after(patience); tims::os::now() < end;) {
    if (pictures.size() == kPicturesMax) pictures.pop_front();
    pictures.push_back(data_of<rack::CameraData>(client, camera, tims::type::kGetNextData));
    auto objects = data_of<rack::ObjRecogData>(client, recogniser, tims::type::kGetData);
    const auto shown = std::ranges::find_if(pictures, [&](const rack::CameraData& picture) {
      return picture.recordingTime - objects.recordingTime == lag;
    });
    if (shown != pictures.end()) return {std::move(*shown), std::move(objects)};
  }
  throw Failure(Exit::kTimeout, "not_recognised",
                fmt::format("{} has no objects of the pictures of {}", client.name_of(recogniser),
                            client.name_of(camera)),
                "its parameter cameraInst selects its camera; or try a longer --timeout");
}

}  // namespace timsctl

// A source that is opened again at its end. Times go on across the ends.
#pragma once

#include "components/devices/video_reader/frame_source.h"

namespace rack::device {

class LoopedSource final : public FrameSource {
 public:
  using Open = Result<std::unique_ptr<FrameSource>> (*)(const DeviceAddress& address);

  LoopedSource(const DeviceAddress& address, Open open, std::unique_ptr<FrameSource> first)
      : address_(address), open_(open), source_(std::move(first)) {}

  Result<bool> next(SourceFrame& frame) override {
    auto got = source_->next(frame);
    if (got && !*got && has_frame_) {
      auto again = open_(address_);
      if (!again) return again.error();
      source_ = std::move(*again);
      begin_ = last_ + gap_;
      got = source_->next(frame);
    }
    if (!got || !*got) return got;
    frame.media += begin_;
    if (has_frame_) gap_ = frame.media - last_;
    last_ = frame.media;
    has_frame_ = true;
    return true;
  }
  [[nodiscard]] std::string description() const override { return source_->description(); }

 private:
  DeviceAddress address_;
  Open open_;
  std::unique_ptr<FrameSource> source_;
  tims::Duration begin_{};  // of this round
  tims::Duration last_{};
  tims::Duration gap_ = std::chrono::milliseconds(50);  // between the last two frames
  bool has_frame_ = false;
};

}  // namespace rack::device

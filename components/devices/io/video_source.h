// The process that reads videos (components/devices/video_reader) and its messages.
//
// FFmpeg, GStreamer and their decoders are 120 libraries that block, print, have threads of their
// own, and decode what strangers send. They run in a process without rights to more than memory and
// time: it is ended when the device is closed, also if it blocks, and if it crashes, the device is
// lost and opened again.
//
// Its standard input is a socket (SOCK_SEQPACKET), its standard output the memory of a FrameReader,
// its standard error a file in memory in which the reason of a failure is found. The first message
// to it is the address of the device.
#pragma once

#include <cstddef>
#include <cstdint>

namespace rack::device {

inline constexpr const char* kVideoReaderProgram = "rack-video-reader";

// The first byte of messages; a text may follow.
enum class VideoNote : std::uint8_t {
  kFrame = 'F',   // from the reader: a new frame is in the memory
  kOpened = 'O',  // from the reader, with a text about format and size
  kFailed = 'E',  // from the reader, with the reason; it ends
  kEnd = 'D',     // from the reader: the end of the file was reached; it ends
  kTaken = 'T',   // to the reader: the frame was copied
};

inline constexpr std::size_t kVideoNoteBytesMax = 16 << 10;

}  // namespace rack::device

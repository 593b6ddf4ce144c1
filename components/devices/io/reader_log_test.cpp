// What FFmpeg, GStreamer and OpenCV of Debian 12 have really printed.
#include "components/devices/io/reader_log.h"

#include <string>

#include <gtest/gtest.h>

namespace rack::device {
namespace reader_log_test {

TEST(ReaderLogTest, ThereMayBeNoReason) {
  EXPECT_EQ(reason_in_log(""), "");
  EXPECT_EQ(reason_in_log("\n \n\r\n"), "");
  EXPECT_EQ(reason_in_log("[ WARN:0@0.006] global ./modules/videoio/src/cap_gstreamer.cpp (1562) "
                          "getProperty OpenCV | GStreamer warning: unhandled property: 6\n"),
            "");
}

TEST(ReaderLogTest, FfmpegStatesItInItsLastLine) {
  EXPECT_EQ(reason_in_log("[OPENCV:FFMPEG:16] Connection to tcp://127.0.0.1:18901?timeout=0 "
                          "failed: Connection refused\n"),
            "Connection to tcp://127.0.0.1:18901?timeout=0 failed: Connection refused");
  EXPECT_EQ(reason_in_log("[tcp @ 0x55993257d800] Failed to resolve hostname nosuch.invalid: Name "
                          "or service not known\n"),
            "Failed to resolve hostname nosuch.invalid: Name or service not known");
  EXPECT_EQ(reason_in_log("[OPENCV:FFMPEG:24] Packet corrupt (stream = 0, dts = 14).\n"
                          "[OPENCV:FFMPEG:16] moov atom not found\n"),
            "moov atom not found");
}

TEST(ReaderLogTest, GstreamerStatesItFirst) {
  EXPECT_EQ(
      reason_in_log(
          "0:00:00.002329941 27462 0x564b6b139920 ERROR           GST_PIPELINE "
          "gst/parse/grammar.y:570:gst_parse_element_make: no element \"nonsense\"\n"
          "0:00:00.002834390 27462 0x564b6b139920 ERROR           GST_PIPELINE "
          "gst/parse/grammar.y:1262:priv_gst_parse_yyparse: link has no source [sink=@0x564b]\n"
          "\n(t:27462): GLib-GObject-WARNING **: 03:07:34.080: invalid cast from 'GstAppSink'\n"
          "[ WARN:0@0.004] global ./modules/videoio/src/cap_gstreamer.cpp (1226) open OpenCV | "
          "GStreamer warning: cannot find appsink in manual pipeline\n"),
      "no element \"nonsense\"");
  EXPECT_EQ(reason_in_log(
                "0:00:00.015392653 18709 0x5638c9c5c6c0 WARN                 filesrc "
                "gstfilesrc.c:553:gst_file_src_start:<filesrc0> error: No such file \"/none\"\n"
                "0:00:00.015432362 18709 0x5638c9c5c6c0 WARN                 basesrc "
                "gstbasesrc.c:3561:gst_base_src_start:<filesrc0> error: Failed to start\n"
                "0:00:00.015450820 18709 0x5638c9c5c6c0 WARN                GST_PADS "
                "gstpad.c:1146:gst_pad_set_active:<filesrc0:src> Failed to activate pad\n"
                "[ WARN:0@0.016] global ./modules/videoio/src/cap_gstreamer.cpp (1356) open OpenCV "
                "| GStreamer warning: unable to start pipeline\n"),
            "No such file \"/none\"");
  EXPECT_EQ(
      reason_in_log("[ WARN:0@0.003] global ./modules/videoio/src/cap_gstreamer.cpp (1226) open "
                    "OpenCV | GStreamer warning: cannot find appsink in manual pipeline\n"
                    "[ WARN:0@0.003] global ./modules/videoio/src/cap_gstreamer.cpp (862) "
                    "isPipelinePlaying OpenCV | GStreamer warning: GStreamer: pipeline have not "
                    "been created\n"),
      "cannot find appsink in manual pipeline");
}

TEST(ReaderLogTest, OtherTextsOfTheReaderAreReasons) {
  EXPECT_EQ(reason_in_log("rack-video-reader: error while loading shared libraries: "
                          "libopencv_videoio.so.406: cannot open shared object file\n"),
            "rack-video-reader: error while loading shared libraries: libopencv_videoio.so.406: "
            "cannot open shared object file");
}

TEST(ReaderLogTest, WhatStrangersCanMakeThemPrintIsHarmless) {
  EXPECT_EQ(reason_in_log("Location rtsp://u:secret@cam/1 \x1B[31m\xFF moved"),
            "Location rtsp://u:***@cam/1  [31m  moved");
  EXPECT_EQ(reason_in_log(std::string(300, 'x')).size(), 300U);
  EXPECT_EQ(reason_in_log(std::string(301, 'x')).size(), 300U);
  for (const char* odd : {"[", "[OPENCV:FFMPEG:", "[x @ 0x", "0: ERROR ", "0: WARN <", "] ", "[]"})
    EXPECT_LE(reason_in_log(odd).size(), 20U) << odd;
}

}  // namespace reader_log_test
}  // namespace rack::device

# RACK_WITH_OPENCV, and the target `opencv` for all that use it. Debian's parts of OpenCV (91 MB) come without
# OpenCVConfig.cmake and opencv4.pc, which are in libopencv-dev only (147 MB): so they are found by name.
option(RACK_WITH_OPENCV "components with pictures: cameras, intensities of images, pictures of maps, plots as PNG (OpenCV)" ON)
if(NOT RACK_WITH_OPENCV)
  message(STATUS "RACK_WITH_OPENCV=OFF: without CameraV4l, CameraDcam, CameraJpeg, camera-calibrate, map-maker, "
                 "ObjRecogMarkers, ObjRecogPeople, marker-print, rack-dora, cameras of World, maps as PGM or PNG and plots as PNG; "
                 "Scan2d without cameraInst")
  return()
endif()

# In the order of linking: a part needs only those behind it.
set(opencv_parts objdetect videoio calib3d features2d imgcodecs imgproc core)
set(opencv_packages "")
set(opencv_missing "")
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
foreach(part ${opencv_parts})
  list(APPEND opencv_packages libopencv-${part}-dev)
  find_library(OPENCV_${part}_LIBRARY opencv_${part})
  find_file(OPENCV_${part}_HEADER opencv2/${part}.hpp PATHS ${OPENCV_INCLUDE_DIR} NO_DEFAULT_PATH)
  mark_as_advanced(OPENCV_${part}_LIBRARY OPENCV_${part}_HEADER)
  if(NOT OPENCV_${part}_LIBRARY OR NOT OPENCV_${part}_HEADER)
    list(APPEND opencv_missing ${part})
  endif()
endforeach()
mark_as_advanced(OPENCV_INCLUDE_DIR)
if(opencv_missing)
  list(JOIN opencv_missing ", " opencv_missing)
  list(JOIN opencv_packages " " opencv_packages)
  message(FATAL_ERROR "OpenCV is missing (${opencv_missing}): "
                      "apt-get install --no-install-recommends ${opencv_packages} (tools/dev setup), "
                      "or build without pictures: -DRACK_WITH_OPENCV=OFF")
endif()

# Its headers warn with our options, and few sources include them. A program is linked only to the parts that
# it uses: imgcodecs brings 120 libraries.
add_library(opencv INTERFACE)
target_include_directories(opencv SYSTEM INTERFACE ${OPENCV_INCLUDE_DIR})
target_link_options(opencv INTERFACE LINKER:--as-needed)
foreach(part ${opencv_parts})
  target_link_libraries(opencv INTERFACE ${OPENCV_${part}_LIBRARY})
endforeach()

# SPDX-License-Identifier: MIT
# Trilat::OpenCV: OpenCV's core and imgproc, from its own CMake package where there is one. Debian's
# libopencv-imgproc-dev has none (only libopencv-dev, which brings VTK and MPI along), so headers and libraries
# are looked for as well. An imported target's headers are system headers: their warnings are not ours.
find_package(OpenCV 4 QUIET COMPONENTS core imgproc CONFIG)
if(OpenCV_FOUND)
  set(TRILAT_OPENCV_INCLUDES ${OpenCV_INCLUDE_DIRS})
  set(TRILAT_OPENCV_LIBRARIES opencv_imgproc opencv_core)
  set(TRILAT_OPENCV_VERSION ${OpenCV_VERSION})
else()
  find_path(TRILAT_OPENCV_INCLUDES opencv2/imgproc.hpp PATH_SUFFIXES opencv4)
  find_library(TRILAT_OPENCV_CORE opencv_core)
  find_library(TRILAT_OPENCV_IMGPROC opencv_imgproc)
  if(NOT (TRILAT_OPENCV_INCLUDES AND TRILAT_OPENCV_CORE AND TRILAT_OPENCV_IMGPROC))
    message(FATAL_ERROR "OpenCV 4 (core and imgproc) was not found; on Debian: apt-get install libopencv-imgproc-dev")
  endif()
  set(TRILAT_OPENCV_LIBRARIES ${TRILAT_OPENCV_IMGPROC} ${TRILAT_OPENCV_CORE})
  file(STRINGS ${TRILAT_OPENCV_INCLUDES}/opencv2/core/version.hpp numbers REGEX "define CV_VERSION_(MAJOR|MINOR|REVISION) ")
  string(REGEX MATCHALL "[0-9]+" TRILAT_OPENCV_VERSION "${numbers}")
  list(JOIN TRILAT_OPENCV_VERSION . TRILAT_OPENCV_VERSION)
endif()
add_library(Trilat::OpenCV INTERFACE IMPORTED GLOBAL)
set_target_properties(Trilat::OpenCV PROPERTIES
  INTERFACE_INCLUDE_DIRECTORIES "${TRILAT_OPENCV_INCLUDES}" INTERFACE_LINK_LIBRARIES "${TRILAT_OPENCV_LIBRARIES}")

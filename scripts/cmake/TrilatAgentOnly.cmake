# SPDX-License-Identifier: MIT
# What an agent needs of other libraries: zlib for its system, and headers of the machine that compiles. Those lie
# among headers that a cross-compiler must not see, so links to them are put into a folder of their own.
set(ZLIB_USE_STATIC_LIBS ON)
find_package(ZLIB REQUIRED)
find_package(Threads REQUIRED)

find_path(TRILAT_CLI11 CLI/CLI.hpp PATHS /usr/include NO_CMAKE_FIND_ROOT_PATH REQUIRED)
find_path(TRILAT_EIGEN Eigen/Core PATHS /usr/include/eigen3 NO_CMAKE_FIND_ROOT_PATH REQUIRED)
set(headers ${PROJECT_BINARY_DIR}/headers)
file(MAKE_DIRECTORY ${headers})
file(CREATE_LINK ${TRILAT_CLI11}/CLI ${headers}/CLI SYMBOLIC)
file(CREATE_LINK ${TRILAT_EIGEN}/Eigen ${headers}/Eigen SYMBOLIC)
foreach(library CLI11::CLI11 Eigen3::Eigen)
  add_library(${library} INTERFACE IMPORTED GLOBAL)
  set_target_properties(${library} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES ${headers})
endforeach()

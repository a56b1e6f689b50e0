# SPDX-License-Identifier: MIT
# One place owns the flags. A room, or a part of one, is a static library made by trilat_room(); its headers
# are also compiled alone, which proves that each includes what it uses.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(TRILAT_CCACHE ccache)
if(TRILAT_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # What one clone compiled serves another: the cache knows files by their paths inside the project.
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${TRILAT_CCACHE})
endif()

add_library(trilat_flags INTERFACE)
target_include_directories(trilat_flags INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(trilat_flags INTERFACE
  -Wall -Wextra -Werror=switch -Werror=switch-enum -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wdouble-promotion -ffp-contract=off
  # False alarms of GCC 12: on string concatenation, on optional values, and on what files that are compiled
  # together keep to themselves.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict -Wno-subobject-linkage -Wno-maybe-uninitialized>)
if(TRILAT_WERROR)
  target_compile_options(trilat_flags INTERFACE -Werror)
endif()
if(TRILAT_SANITIZE)
  add_compile_options(-fsanitize=${TRILAT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${TRILAT_SANITIZE})
  # Ceres is a static library whose Eigen allocates differently under the address sanitizer.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()

# The files of a folder share what their headers cost: up to twelve are compiled as one.
# So a name in an anonymous namespace stands once in a folder, and hides none of a header.
option(TRILAT_UNITY "Compile several files together; quicker for all, slower after a change of one" ON)
function(trilat_unity name)
  set(count 0)
  foreach(source ${ARGN})
    cmake_path(GET source PARENT_PATH folder)
    math(EXPR group "${count} / 12")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${folder}_${group}")
    math(EXPR count "${count} + 1")
  endforeach()
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${TRILAT_UNITY} UNITY_BUILD_MODE GROUP)
endfunction()

# trilat_room(NAME [SOURCES …] [HEADERS …] [PUBLIC targets…] [PRIVATE targets…])
function(trilat_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;HEADERS;PUBLIC;PRIVATE" ${ARGN})
  if(ROOM_SOURCES)
    add_library(${name} STATIC ${ROOM_SOURCES})
    target_link_libraries(${name} PUBLIC trilat_flags ${ROOM_PUBLIC} PRIVATE ${ROOM_PRIVATE})
    trilat_unity(${name} ${ROOM_SOURCES})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE trilat_flags ${ROOM_PUBLIC})
  endif()
  target_sources(${name} PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${ROOM_HEADERS})
  set_target_properties(${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
endfunction()

# trilat_test(room SOURCES … LINK …): one test binary a room.
function(trilat_test name)
  cmake_parse_arguments(TEST "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name} PRIVATE ${TEST_LINK} trilat_test_support GTest::gmock_main)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(TRILAT_SANITIZE MATCHES undefined)  # of the tests themselves: it doubles what compiling them costs
    target_compile_options(${name} PRIVATE -fno-sanitize=undefined)
  endif()
  trilat_unity(${name} ${TEST_SOURCES})
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60)
endfunction()

# trilat_embed(target HEADER path FILES a.json …): makes a header with one constant a file (a.json -> embedded::a_json),
# so that the program needs no data files beside it.
function(trilat_embed target)
  cmake_parse_arguments(EMBED "" "HEADER" "FILES" ${ARGN})
  set(text "// Made by CMake from the files named below.\n#pragma once\n\nnamespace trilat::embedded {\n")
  foreach(file IN LISTS EMBED_FILES)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    file(READ ${file} content)
    get_filename_component(name ${file} NAME)
    string(MAKE_C_IDENTIFIER ${name} name)
    string(APPEND text "\ninline constexpr const char* ${name} = R\"json(${content})json\";\n")
  endforeach()
  string(APPEND text "\n}  // namespace trilat::embedded\n")
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/embedded/${EMBED_HEADER} CONTENT "${text}" @ONLY)
  target_include_directories(${target} PRIVATE ${PROJECT_BINARY_DIR}/embedded)
endfunction()

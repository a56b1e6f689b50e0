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
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 CCACHE_DEPEND=1
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${TRILAT_CCACHE})
endif()

# -O3 is a tenth slower to compile and no faster to run: what counts is vectorised by hand.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")

add_library(trilat_flags INTERFACE)
target_include_directories(trilat_flags INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(trilat_flags INTERFACE
  -Wall -Wextra -Werror=switch -Werror=switch-enum -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wdouble-promotion -ffp-contract=off
  # False alarms of GCC 12: on string concatenation, on optional values, and on what files that are compiled
  # together keep to themselves. Below 1 GB it collects no garbage, which saves a tenth of the time.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict -Wno-subobject-linkage -Wno-maybe-uninitialized --param=ggc-min-heapsize=1000000>)
if(TRILAT_WERROR)
  target_compile_options(trilat_flags INTERFACE -Werror)
endif()
if(TRILAT_CHECKED)
  target_compile_definitions(trilat_flags INTERFACE _GLIBCXX_ASSERTIONS)
endif()
if(TRILAT_SANITIZE)
  add_compile_options(-fsanitize=${TRILAT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${TRILAT_SANITIZE})
  # Ceres is a static library whose Eigen allocates differently under the address sanitizer.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()

# What costs most is done once. The dearest headers are parsed once a build, and the files of one folder are compiled
# together: a list of SOURCES is one translation unit, and `--` in it begins the next. So a name in an anonymous
# namespace stands once in its unit, and hides none of a header. The debug preset compiles each file alone, without those
# headers; each .cpp includes its own header first.
option(TRILAT_UNITY "Compile several files together; quicker for all, slower after a change of one" ON)
option(TRILAT_PCH "Parse the dearest headers of other libraries once" ON)
function(trilat_together name headers)
  set(unit 0)
  foreach(source ${ARGN})
    if(source STREQUAL "--")
      math(EXPR unit "${unit} + 1")
    else()
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${unit}")
    endif()
  endforeach()
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${TRILAT_UNITY} UNITY_BUILD_MODE GROUP)
  if(TARGET ${headers})
    target_precompile_headers(${name} REUSE_FROM ${headers})
  endif()
endfunction()

# trilat_headers(name LINK targets… HEADERS headers…): headers that trilat_together() gives its targets.
function(trilat_headers name)
  if(NOT TRILAT_PCH)
    return()
  endif()
  cmake_parse_arguments(SET "" "" "LINK;HEADERS" ${ARGN})
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/headers/${name}.cpp CONTENT "")
  add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/headers/${name}.cpp)
  target_link_libraries(${name} PRIVATE trilat_flags ${SET_LINK})
  target_precompile_headers(${name} PRIVATE ${SET_HEADERS})
endfunction()

# trilat_room(NAME [SOURCES …] [HEADERS …] [PUBLIC targets…] [PRIVATE targets…])
function(trilat_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;HEADERS;PUBLIC;PRIVATE" ${ARGN})
  if(ROOM_SOURCES)
    set(files ${ROOM_SOURCES})
    list(REMOVE_ITEM files --)
    add_library(${name} STATIC ${files})
    target_link_libraries(${name} PUBLIC trilat_flags ${ROOM_PUBLIC} PRIVATE ${ROOM_PRIVATE})
    if(TRILAT_UNDEFINED_OUTSIDE AND NOT CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/(datasets|recorders)")
      target_compile_options(${name} PRIVATE -fno-sanitize=undefined)
    endif()
    trilat_together(${name} trilat_room_headers ${ROOM_SOURCES})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE trilat_flags ${ROOM_PUBLIC})
  endif()
  target_sources(${name} PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${ROOM_HEADERS})
  set_target_properties(${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
endfunction()

# trilat_test(NAME SOURCES … LINK … [LABELS …] [SHARDS n] [STATISTICS patterns…]): one test binary a room, run as a
# whole or in n parts. Labels choose what the sanitizers see (scripts/check_all): `outside` reads what comes from outside,
# `walk` is a whole use of the program, `statistics` are Monte-Carlo tests, named by patterns of GoogleTest.
function(trilat_test name)
  cmake_parse_arguments(TEST "" "SHARDS" "SOURCES;LINK;LABELS;STATISTICS" ${ARGN})
  set(files ${TEST_SOURCES})
  list(REMOVE_ITEM files --)
  add_executable(${name} ${files})
  target_link_libraries(${name} PRIVATE ${TEST_LINK} trilat_test_support GTest::gmock_main)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(TRILAT_SANITIZE MATCHES undefined)  # of the tests themselves: it doubles what compiling them costs
    target_compile_options(${name} PRIVATE -fno-sanitize=undefined)
  endif()
  trilat_together(${name} trilat_test_headers ${TEST_SOURCES})
  list(JOIN TEST_STATISTICS ":" patterns)
  set(no_test "] 0 tests from 0 test suites")  # a pattern that matches nothing checks nothing
  if(patterns)
    add_test(NAME ${name}.statistics COMMAND ${name} --gtest_brief=1 --gtest_filter=${patterns})
    set_tests_properties(${name}.statistics PROPERTIES LABELS statistics FAIL_REGULAR_EXPRESSION ${no_test})
  endif()
  if(NOT TEST_SHARDS)
    set(TEST_SHARDS 1)
  endif()
  math(EXPR last "${TEST_SHARDS} - 1")
  foreach(shard RANGE ${last})
    add_test(NAME ${name}.${shard} COMMAND ${name} --gtest_brief=1 --gtest_filter=-${patterns})
    set_tests_properties(${name}.${shard} PROPERTIES LABELS "${TEST_LABELS}" TIMEOUT 900 FAIL_REGULAR_EXPRESSION ${no_test}
      ENVIRONMENT "GTEST_TOTAL_SHARDS=${TEST_SHARDS};GTEST_SHARD_INDEX=${shard}")
  endforeach()
endfunction()

# trilat_embed(target HEADER path [LIST name] FILES a.json …): makes a header with one constant a file (a.json ->
# embedded::a_json), and if asked a list of all of them, each {"a", a_json},
# so that the program needs no data files beside it.
function(trilat_embed target)
  cmake_parse_arguments(EMBED "" "HEADER;LIST" "FILES" ${ARGN})
  set(text "// Made by CMake from the files named below.\n#pragma once\n\nnamespace trilat::embedded {\n")
  foreach(file IN LISTS EMBED_FILES)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    file(READ ${file} content)
    get_filename_component(name ${file} NAME)
    get_filename_component(stem ${file} NAME_WE)
    string(MAKE_C_IDENTIFIER ${name} name)
    string(APPEND list "{\"${stem}\", ${name}}, ")
    string(APPEND text "\ninline constexpr const char* ${name} = R\"json(${content})json\";\n")
  endforeach()
  if(EMBED_LIST)
    string(APPEND text "\ninline constexpr struct { const char *name, *text; } ${EMBED_LIST}[] = {${list}};\n")
  endif()
  string(APPEND text "\n}  // namespace trilat::embedded\n")
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/embedded/${EMBED_HEADER} CONTENT "${text}" @ONLY)
  target_include_directories(${target} PRIVATE ${PROJECT_BINARY_DIR}/embedded)
endfunction()

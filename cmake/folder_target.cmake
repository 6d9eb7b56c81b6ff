# secondlook_folder(NAME DEPENDS … LIBRARIES …): one library per folder, made of every .cc in it.
# DEPENDS are other folders; tests/layering_test holds the #includes to the same arrows.
function(secondlook_folder name)
  cmake_parse_arguments(FOLDER "" "" "DEPENDS;LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS *.cc)
  set(depends ${FOLDER_DEPENDS})
  list(TRANSFORM depends PREPEND secondlook_)
  if(sources)
    add_library(secondlook_${name} STATIC ${sources})
    target_link_libraries(secondlook_${name} PUBLIC secondlook_options ${depends}
                                                    ${FOLDER_LIBRARIES})
    if(name STREQUAL common)
      target_precompile_headers(secondlook_common PRIVATE ${SECONDLOOK_PRECOMPILED})
    else()
      target_precompile_headers(secondlook_${name} REUSE_FROM secondlook_common)
    endif()
  else()
    add_library(secondlook_${name} INTERFACE)
    target_link_libraries(secondlook_${name} INTERFACE secondlook_options ${depends}
                                                       ${FOLDER_LIBRARIES})
  endif()
endfunction()

# secondlook_test(NAME DEPENDS …): tests/NAME/*_test.cc (and its other .cc) as one executable
# NAME_test, labelled NAME. ALONE: no other test runs beside it, as it goes by the time of the wall.
function(secondlook_test name)
  cmake_parse_arguments(TEST "ALONE" "" "DEPENDS;LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cc)
  if(NOT sources)
    return()
  endif()
  set(depends ${TEST_DEPENDS})
  list(TRANSFORM depends PREPEND secondlook_)
  add_executable(${name}_test ${sources})
  target_link_libraries(${name}_test PRIVATE ${depends} ${TEST_LIBRARIES} GTest::gmock
                                             GTest::gtest_main)
  if(name STREQUAL common)
    target_precompile_headers(common_test PRIVATE ${SECONDLOOK_PRECOMPILED}
                                                  ${SECONDLOOK_PRECOMPILED_TEST})
  else()
    target_precompile_headers(${name}_test REUSE_FROM common_test)
  endif()
  gtest_discover_tests(${name}_test
                       WORKING_DIRECTORY ${CMAKE_SOURCE_DIR}
                       DISCOVERY_TIMEOUT 60
                       PROPERTIES LABELS ${name} TIMEOUT 300 RUN_SERIAL ${TEST_ALONE})
endfunction()

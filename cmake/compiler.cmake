set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(CCACHE ccache)
if(CCACHE)
  # Sloppiness: what ccache must be told to work with a precompiled header.
  set(CMAKE_CXX_COMPILER_LAUNCHER
      ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
endif()

# The heavy headers, compiled once for the libraries and once for the tests.
set(SECONDLOOK_PRECOMPILED ${CMAKE_SOURCE_DIR}/cmake/precompiled.h)
set(SECONDLOOK_PRECOMPILED_TEST ${CMAKE_SOURCE_DIR}/cmake/precompiled_test.h)

add_library(secondlook_options INTERFACE)
target_include_directories(secondlook_options INTERFACE ${CMAKE_SOURCE_DIR})
# LCM's decoders write doubles through pointers to integers; what reads them must expect it.
target_compile_options(secondlook_options INTERFACE -fno-strict-aliasing -Wall -Wextra
                                                    -Wpedantic -Wshadow -Wno-unknown-pragmas
                                                    -Winvalid-pch -fpch-preprocess)
if(SECONDLOOK_WERROR)
  target_compile_options(secondlook_options INTERFACE -Werror)
endif()
if(SECONDLOOK_SANITIZE)
  target_compile_options(secondlook_options INTERFACE -fsanitize=${SECONDLOOK_SANITIZE}
                                                      -fno-omit-frame-pointer
                                                      -fno-sanitize-recover=all
                                                      -fno-sanitize=vptr)  # lcm-cpp's casts
  target_link_options(secondlook_options INTERFACE -fsanitize=${SECONDLOOK_SANITIZE})
endif()

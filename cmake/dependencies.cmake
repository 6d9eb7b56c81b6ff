# Every library is a Debian package; tools/packages.txt lists them.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED)
find_package(octomap REQUIRED)
find_package(fcl REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(assimp REQUIRED)
find_package(embree REQUIRED)
find_package(nanoflann REQUIRED)
find_package(TBB REQUIRED)
find_package(ZLIB REQUIRED)
find_package(CLI11 REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)
pkg_check_modules(OSMESA REQUIRED IMPORTED_TARGET osmesa)
pkg_check_modules(OPENNI2 REQUIRED IMPORTED_TARGET libopenni2)
pkg_check_modules(HTTPLIB REQUIRED IMPORTED_TARGET cpp-httplib)
# Its definitions would part it from the precompiled header; apps/http.h has them.
set_target_properties(PkgConfig::HTTPLIB PROPERTIES INTERFACE_COMPILE_OPTIONS "")

# A newer LCM has a CMake package; Debian's 1.3.1 has none.
find_package(lcm CONFIG QUIET)
if(lcm_FOUND)
  set(SECONDLOOK_LCM lcm)
else()
  pkg_check_modules(LCM REQUIRED IMPORTED_TARGET lcm)
  # Its -pthread would part it from the precompiled header; threads come with TBB.
  set_target_properties(PkgConfig::LCM PROPERTIES INTERFACE_COMPILE_OPTIONS "")
  set(SECONDLOOK_LCM PkgConfig::LCM)
endif()
find_program(SECONDLOOK_LCM_GEN lcm-gen REQUIRED)

# Debian's OpenCVConfig.cmake comes with the package of all 60 modules; we use a few, so they are
# found by hand.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
foreach(module core imgproc imgcodecs surface_matching features2d objdetect ml dnn aruco calib3d
               video videoio)
  find_library(OPENCV_${module} opencv_${module} REQUIRED)
  add_library(opencv_${module} UNKNOWN IMPORTED)
  set_target_properties(opencv_${module} PROPERTIES IMPORTED_LOCATION ${OPENCV_${module}}
                                                    INTERFACE_INCLUDE_DIRECTORIES
                                                    ${OPENCV_INCLUDE_DIR})
endforeach()

# Kinematics and motion planning. Their CMake and pkg-config files set a language standard or name
# paths that are not there, so that these are found by hand, too.
function(secondlook_import name header library)
  string(TOUPPER ${name} prefix)
  find_path(${prefix}_INCLUDE_DIR ${header} PATH_SUFFIXES ompl-1.5 ompl-1.6 urdfdom REQUIRED)
  find_library(${prefix}_LIBRARY ${library} REQUIRED)
  add_library(${name} UNKNOWN IMPORTED GLOBAL)
  set_target_properties(${name} PROPERTIES IMPORTED_LOCATION ${${prefix}_LIBRARY}
                                           INTERFACE_INCLUDE_DIRECTORIES ${${prefix}_INCLUDE_DIR})
endfunction()
secondlook_import(ompl ompl/base/Planner.h ompl)
secondlook_import(orocos_kdl kdl/chain.hpp orocos-kdl)
secondlook_import(console_bridge console_bridge/console.h console_bridge)
secondlook_import(urdfdom urdf_parser/urdf_parser.h urdfdom_model)
target_link_libraries(urdfdom INTERFACE console_bridge)

# Its own FindOpenVDB.cmake asks for parts of Boost and Blosc that its headers do not use here.
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h REQUIRED)
find_library(OPENVDB_LIBRARY openvdb REQUIRED)
add_library(openvdb UNKNOWN IMPORTED GLOBAL)
set_target_properties(openvdb PROPERTIES IMPORTED_LOCATION ${OPENVDB_LIBRARY}
                                         INTERFACE_INCLUDE_DIRECTORIES ${OPENVDB_INCLUDE_DIR})
target_link_libraries(openvdb INTERFACE TBB::tbb)

# Third-party headers are not ours to warn about.
foreach(library Eigen3::Eigen yaml-cpp fcl octomap nanoflann::nanoflann)
  get_target_property(directories ${library} INTERFACE_INCLUDE_DIRECTORIES)
  if(directories)
    set_target_properties(${library} PROPERTIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES
                                                "${directories}")
  endif()
endforeach()

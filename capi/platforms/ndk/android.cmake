# What the toolchain files of Android share: the C++ library is linked into ours, so that it meets no other.
set(ANDROID_PLATFORM android-26)
set(ANDROID_STL c++_static)
if(NOT DEFINED ENV{ANDROID_NDK_HOME})
  message(FATAL_ERROR "ANDROID_NDK_HOME does not say where the NDK is")
endif()
include($ENV{ANDROID_NDK_HOME}/build/cmake/android.toolchain.cmake)
list(APPEND CMAKE_FIND_ROOT_PATH ${CMAKE_CURRENT_LIST_DIR}/../../../build/cross/${FB_TARGET})

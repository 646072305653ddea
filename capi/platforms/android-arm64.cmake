# Android on AArch64 by the NDK of $ANDROID_NDK_HOME. Not run where this project is tested.
set(ANDROID_ABI arm64-v8a)
set(FB_TARGET android-arm64)
include(${CMAKE_CURRENT_LIST_DIR}/ndk/android.cmake)

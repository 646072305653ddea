# Android on x86-64, as emulators have it, by the NDK of $ANDROID_NDK_HOME. Not run where this project is tested.
set(ANDROID_ABI x86_64)
set(FB_TARGET android-x64)
include(${CMAKE_CURRENT_LIST_DIR}/ndk/android.cmake)

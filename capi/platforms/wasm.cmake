# WebAssembly by Emscripten, Debian's or the one of $EMSCRIPTEN. Exceptions are WebAssembly's own, which all browsers
# have since 2022: with those that go through JavaScript, modules are larger and calls slower.
if(DEFINED ENV{EMSCRIPTEN})
  set(FB_EMSCRIPTEN $ENV{EMSCRIPTEN})
else()
  set(FB_EMSCRIPTEN /usr/share/emscripten)
endif()
include(${FB_EMSCRIPTEN}/cmake/Modules/Platform/Emscripten.cmake)
set(CMAKE_C_FLAGS_INIT "-fwasm-exceptions")
set(CMAKE_CXX_FLAGS_INIT "-fwasm-exceptions")
list(APPEND CMAKE_FIND_ROOT_PATH ${CMAKE_CURRENT_LIST_DIR}/../../build/cross/wasm) # see build_dependencies.sh

# WebAssembly by Emscripten, Debian's or the one of $EMSCRIPTEN; with FB_WASM_SIMD for its SIMD instructions. All browsers
# have these features since 2022. Exceptions that go through JavaScript would make modules larger and calls slower;
# without saturating conversions, loops from floats to integers are not vectorised.
if(DEFINED ENV{EMSCRIPTEN})
  set(FB_EMSCRIPTEN $ENV{EMSCRIPTEN})
else()
  set(FB_EMSCRIPTEN /usr/share/emscripten)
endif()
include(${FB_EMSCRIPTEN}/cmake/Modules/Platform/Emscripten.cmake)
set(flags "-fwasm-exceptions -mnontrapping-fptoint -mbulk-memory -msign-ext")
if(FB_WASM_SIMD)
  string(APPEND flags " -msimd128")
endif()
set(CMAKE_C_FLAGS_INIT "${flags}")
set(CMAKE_CXX_FLAGS_INIT "${flags}")
get_filename_component(FB_CROSS ${CMAKE_CURRENT_LIST_DIR}/../../build/cross/wasm ABSOLUTE)
list(APPEND CMAKE_FIND_ROOT_PATH ${FB_CROSS}) # see build_dependencies.sh

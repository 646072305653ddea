# Fails if LIBRARY needs anything but the system's own libraries, is looked for under another name than SONAME, or, where it
# is OPTIMISED, is larger than a runtime may be.
execute_process(COMMAND ${READELF} --dynamic ${LIBRARY} OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "[][]" " " dynamic "${dynamic}") # brackets would join the elements of a list
string(REGEX MATCHALL "Shared library: +[^ ]+" entries "${dynamic}")
if(NOT entries MATCHES "libc\\.so")
  message(FATAL_ERROR "${LIBRARY}: found no needed libraries in\n${dynamic}")
endif()
foreach(entry ${entries})
  string(REGEX REPLACE ".* " "" name "${entry}")
  if(NOT name MATCHES "^(libc|libm|libstdc\\+\\+|libgcc_s|libgomp|ld-linux[a-z0-9_-]*)\\.so")
    message(FATAL_ERROR "${LIBRARY} needs ${name}")
  endif()
endforeach()

if(NOT "${dynamic}" MATCHES "Library soname: +${SONAME} ")
  message(FATAL_ERROR "${LIBRARY}: the SONAME is not ${SONAME} in\n${dynamic}")
endif()

set(stripped ${OUT}.stripped)
execute_process(COMMAND ${STRIP} -o ${stripped} ${LIBRARY} COMMAND_ERROR_IS_FATAL ANY)
file(SIZE ${stripped} bytes)
if(OPTIMISED AND bytes GREATER 1500000)
  message(FATAL_ERROR "${LIBRARY} has ${bytes} bytes stripped")
endif()

# What of others is in our libraries and programs (third_party.json), with the versions that this machine builds with.

# fb_third_party(OUT PROGRAM): "zlib 1.2.13, Draco 1.5.5, ..." of facebaker, facebaker_bake or tool. Versions are those of
# the Debian packages; elsewhere names alone.
function(fb_third_party out program)
  set(folder ${CMAKE_CURRENT_FUNCTION_LIST_DIR})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/third_party.json)
  file(READ ${folder}/third_party.json components)
  find_program(FB_DPKG_QUERY dpkg-query)
  mark_as_advanced(FB_DPKG_QUERY)
  string(JSON count LENGTH ${components})
  math(EXPR last "${count} - 1")
  set(linked)
  foreach(i RANGE ${last})
    string(JSON users GET ${components} ${i} in)
    if(NOT users MATCHES "\"${program}\"")
      continue()
    endif()
    string(JSON name GET ${components} ${i} name)
    string(JSON package GET ${components} ${i} package)
    set(version "")
    if(FB_DPKG_QUERY)
      execute_process(COMMAND ${FB_DPKG_QUERY} --show --showformat=\${Version} ${package}
                      OUTPUT_VARIABLE version ERROR_QUIET)
      # Without the epoch, Debian's revision and marks of repacking.
      string(REGEX REPLACE "^[0-9]+:|-[^-]*$" "" version "${version}")
      string(REGEX REPLACE "[+.](ds|dfsg)$" "" version "${version}")
    endif()
    string(STRIP "${name} ${version}" words)
    list(APPEND linked "${words}")
  endforeach()
  list(JOIN linked ", " linked)
  set(${out} "${linked}" PARENT_SCOPE)
endfunction()

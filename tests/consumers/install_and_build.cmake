# Installs the build into a folder of its own, then builds and runs programs that know nothing but that folder.
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK}/prefix ${WORK}/app)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix --component sdk)

run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${CMAKE_CURRENT_LIST_DIR}/app -B ${WORK}/app
    -DCMAKE_PREFIX_PATH=${WORK}/prefix -DHELLO=${HELLO}
    -DCMAKE_C_COMPILER=${CC} -DCMAKE_CXX_COMPILER=${CXX})
run(${CMAKE_COMMAND} --build ${WORK}/app)
run(${WORK}/app/hello ${FIXTURE} jaw_open 1)
run(${WORK}/app/strict ${FIXTURE})
run(${WORK}/app/author)

# by_pkg_config(PACKAGE OUT COMPILER ARGUMENT...): compiles with what pkg-config says of the installed package.
function(by_pkg_config package out)
  set(ENV{PKG_CONFIG_PATH} ${WORK}/prefix/${LIBDIR}/pkgconfig)
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs ${package} OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  run(${ARGN} -Wall -Wextra -Werror ${flags} -lm -Wl,-rpath,${WORK}/prefix/${LIBDIR} -o ${WORK}/app/${out})
endfunction()
if(PKG_CONFIG)
  by_pkg_config(facebaker hello_by_pkg_config ${CC} -std=c99 -pedantic-errors ${HELLO})
  run(${WORK}/app/hello_by_pkg_config ${FIXTURE} jaw_open 1)
  by_pkg_config(facebaker_bake author_by_pkg_config ${CXX} -std=c++17 ${CMAKE_CURRENT_LIST_DIR}/app/author.cpp)
  run(${WORK}/app/author_by_pkg_config)
endif()

# The README's program in C, where it expects a face.
file(READ ${README} readme)
string(FIND "${readme}" "```c\n" begin)
string(SUBSTRING "${readme}" ${begin} -1 readme)
string(FIND "${readme}" "\n```\n" end)
math(EXPR length "${end} - 5")
string(SUBSTRING "${readme}" 5 ${length} program)
file(WRITE ${WORK}/app/readme.c "${program}\n")
file(COPY ${FIXTURE} DESTINATION ${WORK}/app/build/quickstart)
file(RENAME ${WORK}/app/build/quickstart/tiny.fbk ${WORK}/app/build/quickstart/sample.fbk)
run(${CC} -std=c99 -Wall -Wextra -Werror readme.c -I${WORK}/prefix/include -L${WORK}/prefix/${LIBDIR} -lfacebaker
    -Wl,-rpath,${WORK}/prefix/${LIBDIR} -o readme WORKING_DIRECTORY ${WORK}/app)
run(./readme WORKING_DIRECTORY ${WORK}/app)

# The installed tool finds the sample face under the prefix: it knows that its controls are not the fixture's.
if(TOOL)
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
  execute_process(COMMAND ${WORK}/prefix/bin/facebaker eval ${FIXTURE} sample RESULT_VARIABLE code ERROR_VARIABLE complaint)
  if(NOT code EQUAL 1 OR NOT complaint MATCHES "the source has [0-9]+")
    message(FATAL_ERROR "the installed tool does not find the sample face: ${complaint}")
  endif()
endif()

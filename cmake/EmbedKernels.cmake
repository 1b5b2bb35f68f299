# Embeds OpenCL files that make one program. Reading a compiled program takes PoCL 20 ms, whatever its size. #line
# directives keep file names and line numbers of compiler messages true.
#
#   kappamu_embed_kernels(kappamu_forward grid/vectors NAMESPACE kappamu::forward FILES grid/prelude.cl grid/vectors.cl ...)
#
# adds to the target a generated source that defines
#   extern const kappamu::device::KernelSource vectors_cl;     (in NAMESPACE)
# At build time this same file runs as a script (-P) and does the writing.
if(CMAKE_SCRIPT_MODE_FILE)
  set(text)
  foreach(file ${FILES})
    file(RELATIVE_PATH file_name ${ROOT} ${file})
    file(READ ${file} piece)
    string(APPEND text "#line 1 \"${file_name}\"\n${piece}")
  endforeach()
  file(WRITE ${OUTPUT} "// Made by cmake/EmbedKernels.cmake.
#include \"device/kernel_source.h\"

namespace ${NAMESPACE} {
extern const kappamu::device::KernelSource ${SYMBOL};
const kappamu::device::KernelSource ${SYMBOL}{\"${NAME}\", R\"opencl(${text})opencl\"};
}  // namespace ${NAMESPACE}
")
  return()
endif()

set(KAPPAMU_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

function(kappamu_embed_kernels target program)
  cmake_parse_arguments(ARG "" "NAMESPACE" "FILES" ${ARGN})
  set(files ${ARG_FILES})
  list(TRANSFORM files PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/${program}.cl.cpp)
  file(RELATIVE_PATH name ${CMAKE_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/${program}.cl)
  get_filename_component(symbol ${program} NAME)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DNAME=${name} -DNAMESPACE=${ARG_NAMESPACE} -DSYMBOL=${symbol}_cl
            -DROOT=${CMAKE_SOURCE_DIR} "-DFILES=${files}" -P ${KAPPAMU_EMBED_SCRIPT}
    DEPENDS ${files} ${KAPPAMU_EMBED_SCRIPT}
    VERBATIM)
  target_sources(${target} PRIVATE ${output})
endfunction()

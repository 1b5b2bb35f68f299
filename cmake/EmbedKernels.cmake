# Embeds OpenCL files. Each text begins with common preludes, if any; #line directives keep file
# names and line numbers of compiler messages true.
#
#   kappamu_embed_kernels(kappamu_forward NAMESPACE kappamu::forward PRELUDES grid/prelude.cl ...
#                         FILES grid/operator.cl ...)
#
# adds to the target, for each file, a generated source that defines
#   extern const kappamu::device::KernelSource operator_cl;     (in NAMESPACE)
# At build time this same file runs as a script (-P) and does the writing.
if(CMAKE_SCRIPT_MODE_FILE)
  set(text)
  foreach(file ${PRELUDES} ${INPUT})
    file(RELATIVE_PATH file_name ${ROOT} ${file})
    file(READ ${file} piece)
    string(APPEND text "#line 1 \"${file_name}\"\n${piece}")
  endforeach()
  file(WRITE ${OUTPUT} "// Made from ${NAME} by cmake/EmbedKernels.cmake.
#include \"device/kernel_source.h\"

namespace ${NAMESPACE} {
extern const kappamu::device::KernelSource ${SYMBOL};
const kappamu::device::KernelSource ${SYMBOL}{\"${NAME}\", R\"opencl(${text})opencl\"};
}  // namespace ${NAMESPACE}
")
  return()
endif()

set(KAPPAMU_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

function(kappamu_embed_kernels target)
  cmake_parse_arguments(ARG "" "NAMESPACE" "PRELUDES;FILES" ${ARGN})
  set(preludes ${ARG_PRELUDES})
  list(TRANSFORM preludes PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  foreach(file ${ARG_FILES})
    set(input ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    set(output ${CMAKE_CURRENT_BINARY_DIR}/${file}.cpp)
    file(RELATIVE_PATH name ${CMAKE_SOURCE_DIR} ${input})
    get_filename_component(symbol ${file} NAME)
    string(REPLACE "." "_" symbol ${symbol})
    add_custom_command(
      OUTPUT ${output}
      COMMAND ${CMAKE_COMMAND} -DINPUT=${input} -DOUTPUT=${output} -DNAME=${name}
              -DNAMESPACE=${ARG_NAMESPACE} -DSYMBOL=${symbol} -DROOT=${CMAKE_SOURCE_DIR}
              "-DPRELUDES=${preludes}" -P ${KAPPAMU_EMBED_SCRIPT}
      DEPENDS ${input} ${preludes} ${KAPPAMU_EMBED_SCRIPT}
      VERBATIM)
    target_sources(${target} PRIVATE ${output})
  endforeach()
endfunction()

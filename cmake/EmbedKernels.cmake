# Embeds OpenCL files. Each text begins with a common prelude; #line directives keep file names and
# line numbers of compiler messages true.
#
#   kappamu_embed_kernels(kappamu_forward NAMESPACE kappamu::forward PRELUDE grid/prelude.cl
#                         FILES grid/operator.cl ...)
#
# adds to the target, for each file, a generated source that defines
#   extern const kappamu::device::KernelSource operator_cl;     (in NAMESPACE)
# At build time this same file runs as a script (-P) and does the writing.
if(CMAKE_SCRIPT_MODE_FILE)
  file(READ ${INPUT} text)
  set(text "#line 1 \"${NAME}\"\n${text}")
  if(PRELUDE)
    file(READ ${PRELUDE} prelude)
    set(text "#line 1 \"${PRELUDE_NAME}\"\n${prelude}${text}")
  endif()
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
  cmake_parse_arguments(ARG "" "NAMESPACE;PRELUDE" "FILES" ${ARGN})
  set(prelude_options)
  if(ARG_PRELUDE)
    set(prelude ${CMAKE_CURRENT_SOURCE_DIR}/${ARG_PRELUDE})
    file(RELATIVE_PATH prelude_name ${CMAKE_SOURCE_DIR} ${prelude})
    set(prelude_options -DPRELUDE=${prelude} -DPRELUDE_NAME=${prelude_name})
  endif()
  foreach(file ${ARG_FILES})
    set(input ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    set(output ${CMAKE_CURRENT_BINARY_DIR}/${file}.cpp)
    file(RELATIVE_PATH name ${CMAKE_SOURCE_DIR} ${input})
    get_filename_component(symbol ${file} NAME)
    string(REPLACE "." "_" symbol ${symbol})
    add_custom_command(
      OUTPUT ${output}
      COMMAND ${CMAKE_COMMAND} -DINPUT=${input} -DOUTPUT=${output} -DNAME=${name}
              -DNAMESPACE=${ARG_NAMESPACE} -DSYMBOL=${symbol} ${prelude_options}
              -P ${KAPPAMU_EMBED_SCRIPT}
      DEPENDS ${input} ${prelude} ${KAPPAMU_EMBED_SCRIPT}
      VERBATIM)
    target_sources(${target} PRIVATE ${output})
  endforeach()
endfunction()

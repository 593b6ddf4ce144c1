# Messages in other languages, from the descriptions that the C++ structs give. The generator (python/rack/generate)
# needs Python's interpreter only.
if(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3)  # Debian's, which has Debian's numpy, before one of a version manager
endif()
find_package(Python3 3.9 REQUIRED COMPONENTS Interpreter)

set(rack_schema ${CMAKE_BINARY_DIR}/schema.json)
file(GLOB rack_generators CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/python/rack/generate/*.py)

# rack_schema(): the target that writes the description.
function(rack_schema)
  # A program of another architecture than this machine's must be named by its path.
  add_custom_command(OUTPUT ${rack_schema} DEPENDS tims-schema
                     COMMAND ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:tims-schema> > ${rack_schema}
                     COMMENT "Describing all messages" VERBATIM)
  add_custom_target(rack_schema DEPENDS ${rack_schema})
endfunction()

# rack_generated(file options...): a file that the generator writes.
function(rack_generated file)
  add_custom_command(OUTPUT ${file}
    COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${CMAKE_SOURCE_DIR}/python/rack PYTHONDONTWRITEBYTECODE=1
            ${Python3_EXECUTABLE} -m generate ${ARGN} ${rack_schema} > ${file}
    DEPENDS ${rack_schema} rack_schema ${rack_generators} COMMENT "Writing ${file}" VERBATIM)
endfunction()

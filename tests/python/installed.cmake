# Installs the Python component of a build and imports it from there.
file(REMOVE_RECURSE ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --component python --prefix ${PREFIX} COMMAND_ERROR_IS_FATAL ANY)
file(GLOB_RECURSE files RELATIVE ${PREFIX} ${PREFIX}/*)
list(LENGTH files count)
if(NOT count EQUAL 4)
  message(FATAL_ERROR "the component should be the package's four files, not: ${files}")
endif()
set(ENV{PYTHONPATH} ${PREFIX}/${PACKAGES})
execute_process(COMMAND ${PYTHON} -c "import lumisweep; assert lumisweep.__file__.startswith('${PREFIX}'); print(lumisweep.__version__)"
  COMMAND_ERROR_IS_FATAL ANY)

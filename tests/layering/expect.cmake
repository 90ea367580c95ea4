# Shared by the tests of the checks in this folder: plants files into a scratch tree and expects a
# check to pass or to refuse it. The including script sets WORK, by its command line, and CHECK.

if(NOT DEFINED WORK)
  message(FATAL_ERROR "WORK must name a scratch folder")
endif()

# Runs CHECK on the scratch tree.
function(run_check status_variable output_variable)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -D "ROOT=${WORK}" -P "${CHECK}"
    RESULT_VARIABLE status
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  set(${status_variable} "${status}" PARENT_SCOPE)
  set(${output_variable} "${output}" PARENT_SCOPE)
endfunction()

# Writes the files that every tree has. A script may define its own.
function(make_tree)
endfunction()

# Expects a tree with the line `line` in the file `path` to pass (`expected` is PASS) or to be refused
# with a message that names `path`. Two further arguments are path and line of another file.
function(expect expected path line)
  file(REMOVE_RECURSE "${WORK}")
  make_tree()
  if(ARGC GREATER 3)
    file(WRITE "${WORK}/${ARGV3}" "#pragma once\n\n${ARGV4}\n")
  endif()
  file(WRITE "${WORK}/${path}" "\n${line}\n")
  run_check(status output)
  if(expected STREQUAL "PASS" AND NOT status EQUAL 0)
    message(SEND_ERROR "must be allowed: ${line} in ${path}\n${output}")
  elseif(expected STREQUAL "REFUSE")
    if(status EQUAL 0)
      message(SEND_ERROR "was not caught: ${line} in ${path}")
    elseif(NOT output MATCHES "${path}")
      message(SEND_ERROR "the message does not name ${path}:\n${output}")
    endif()
  endif()
  file(REMOVE_RECURSE "${WORK}")
endfunction()

# Expects the check to refuse a tree without sources: it is a wrong path, not a clean tree.
function(expect_empty_tree_is_refused)
  file(REMOVE_RECURSE "${WORK}")
  file(MAKE_DIRECTORY "${WORK}")
  run_check(status output)
  if(status EQUAL 0)
    message(SEND_ERROR "an empty tree passed")
  endif()
  file(REMOVE_RECURSE "${WORK}")
endfunction()

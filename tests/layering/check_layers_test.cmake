# Plants includes and types into trees of their own and expects check_layers.cmake to tell right from wrong.
#
#   cmake -D WORK=<scratch folder> -P check_layers_test.cmake

if(NOT DEFINED WORK)
  message(FATAL_ERROR "WORK must name a scratch folder")
endif()
set(CHECK "${CMAKE_CURRENT_LIST_DIR}/check_layers.cmake")

# Expects a tree whose only file is `path` with the line `line` to pass (`expected` is PASS) or to be
# refused by name. What follows is written to `server/other.h`.
function(expect expected path line)
  file(REMOVE_RECURSE "${WORK}")
  if(ARGN)
    file(WRITE "${WORK}/server/other.h" "#pragma once\n\n${ARGN}\n")
  endif()
  file(WRITE "${WORK}/${path}" "#pragma once\n\n${line}\n")
  execute_process(
    COMMAND ${CMAKE_COMMAND} -D "ROOT=${WORK}" -P "${CHECK}"
    RESULT_VARIABLE status
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  if(expected STREQUAL "PASS" AND NOT status EQUAL 0)
    message(SEND_ERROR "must be allowed: ${line} in ${path}\n${output}")
  elseif(expected STREQUAL "REFUSE")
    if(status EQUAL 0)
      message(SEND_ERROR "was not caught: ${line} in ${path}")
    elseif(NOT output MATCHES "${path}")
      message(SEND_ERROR "the message does not name ${path}:\n${output}")
    endif()
  endif()
endfunction()

expect(PASS core/volume/tsdf_grid.cpp "#include <openvdb/openvdb.h>")
expect(PASS core/frame/frame.h "#include <vector>")
expect(REFUSE core/frame/frame.h "#include <grpcpp/grpcpp.h>")
expect(REFUSE core/frame/frame.h "#include \"steadymap/v1/frame.pb.h\"")
expect(REFUSE core/frame/frame.h "#include \"server/store/model/store.h\"")
expect(REFUSE core/store.cpp "#include <fstream>")
expect(REFUSE core/clock.cpp "  #  include   <chrono>  // now")
expect(PASS proto/convert.h "#include \"steadymap/v1/frame.pb.h\"")
expect(PASS proto/grpc_status.h "#include <grpcpp/support/status.h>")
expect(REFUSE proto/convert.h "#include <grpcpp/grpcpp.h>")
expect(REFUSE proto/convert.h "#include \"client/map/map_client.h\"")
expect(PASS client/cli/main.cpp "#include \"steadymap/v1/map_service.grpc.pb.h\"")
expect(REFUSE client/cli/main.cpp "#include \"server/store/model/store.h\"")
expect(REFUSE client/map/map_client.h "#include <rocksdb/db.h>")
expect(PASS server/main.cpp "#include <rocksdb/db.h>")
expect(REFUSE server/main.cpp "#include \"client/map/map_client.h\"")
expect(REFUSE server/main.cpp "#include \"tests/server/fake_store.h\"")
expect(PASS core/step.h "struct Step {" "struct OtherStep {")
expect(PASS core/step.h "struct Step\;" "struct Step {")
expect(PASS core/step.h "  struct Step {" "struct Step {")
expect(REFUSE core/step.h "struct Step {" "class Step final : public Base {")
expect(REFUSE core/step.h "enum class Step : char {" "struct Step {}\;")

# A tree without sources is a wrong path, not a clean tree.
file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}")
execute_process(
  COMMAND ${CMAKE_COMMAND} -D "ROOT=${WORK}" -P "${CHECK}"
  RESULT_VARIABLE status
  OUTPUT_QUIET ERROR_QUIET)
if(status EQUAL 0)
  message(SEND_ERROR "an empty tree passed")
endif()
file(REMOVE_RECURSE "${WORK}")

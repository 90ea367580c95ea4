# Plants includes and types into trees of their own. check_layers.cmake must accept the allowed ones and
# refuse the others.
#
#   cmake -D WORK=<scratch folder> -P check_layers_test.cmake

set(CHECK "${CMAKE_CURRENT_LIST_DIR}/check_layers.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/expect.cmake")

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
expect(PASS client/cli/main.cpp "#include <nlohmann/json.hpp>")
expect(REFUSE core/query/mesh_file.cpp "#include <nlohmann/json.hpp>")
expect(REFUSE client/cli/main.cpp "#include \"server/store/model/store.h\"")
expect(REFUSE client/map/map_client.h "#include <rocksdb/db.h>")
expect(PASS server/main.cpp "#include <rocksdb/db.h>")
expect(REFUSE server/main.cpp "#include \"client/map/map_client.h\"")
expect(REFUSE server/main.cpp "#include \"tests/server/fake_store.h\"")
expect(PASS core/step.h "struct Step {" server/other.h "struct OtherStep {")
expect(PASS core/step.h "struct Step\;" server/other.h "struct Step {")
expect(PASS core/step.h "  struct Step {" server/other.h "struct Step {")
expect(REFUSE core/step.h "struct Step {" server/other.h "class Step final : public Base {")
expect(REFUSE core/step.h "enum class Step : char {" server/other.h "struct Step {}\;")

expect_empty_tree_is_refused()

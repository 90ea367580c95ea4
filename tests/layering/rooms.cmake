# The rooms of each layer, ground floor first: a room is a folder, and names the rooms of its layer
# whose headers its files may include. Each lists only rooms above it in its table, so that no circle
# can come about. "." is the layer's own folder.

set(core_ROOMS
    "types:"
    "geometry: types"
    "frame: types geometry"
    "volume: types geometry frame"
    "integration: types geometry frame volume"
    "map: types geometry volume"
    "query: types geometry volume map"
    "working: types geometry volume integration map"
    "registration: geometry volume map working"
    "association: types geometry frame volume integration map working"
    "change: types frame volume integration map working association"
    "objects: types geometry volume map working registration association change"
    "robot: types geometry frame volume integration map working association change"
    "policy: types geometry frame volume integration map working registration association change objects robot"
    ".: types frame integration map working policy")
# All files of the layer's own folder, without their endings.
set(core_TOP_FILES mapper)

set(server_ROOMS
    "process:"
    "store/disk:"
    "store/model: store/disk"
    "store/database: store/disk store/model"
    "store/log: store/disk store/model store/database"
    "store/map: store/disk store/model store/database store/log"
    "store: store/disk store/model store/database store/map"
    "store/repair: store/disk store/model store/database store/log store/map store"
    "config: process store/model"
    "rpc: process config"
    "mapping: process store/model config"
    "upload: process store/model config rpc mapping"
    "watch: process store/model rpc mapping upload"
    "query: process store/model rpc mapping"
    "maps: process store/database store/map config rpc mapping upload watch"
    ".: process store/model store/repair config rpc mapping upload watch query maps")
set(server_TOP_FILES command_line maintenance main server store_tools)

set(client_ROOMS
    "transport:"
    "upload: transport"
    "watch: transport"
    "map: transport watch"
    "picture:"
    "dataset/files:"
    "dataset/layouts: dataset/files"
    "dataset: upload dataset/files dataset/layouts"
    "bench/simulator/scene: dataset/layouts"
    "bench/simulator/routes: dataset/layouts bench/simulator/scene"
    "bench/simulator/sensor: bench/simulator/scene"
    "bench/simulator: upload dataset dataset/layouts bench/simulator/scene bench/simulator/routes bench/simulator/sensor"
    "bench/evaluation/truth: bench/simulator bench/simulator/scene bench/simulator/sensor"
    "bench/evaluation/score: bench/evaluation/truth"
    "bench/evaluation/method: bench/evaluation/truth"
    "bench/evaluation/room: bench/simulator bench/simulator/routes bench/simulator/scene bench/simulator/sensor bench/evaluation/method bench/evaluation/score bench/evaluation/truth"
    "bench/evaluation/composite: dataset bench/simulator/scene bench/simulator/sensor bench/evaluation/method bench/evaluation/room bench/evaluation/score bench/evaluation/truth"
    "bench/evaluation/report: picture bench/evaluation/score bench/evaluation/method"
    "bench/evaluation: dataset bench/simulator bench/evaluation/score bench/evaluation/method bench/evaluation/report"
    "bench/evaluation/fleet: bench/simulator bench/simulator/scene bench/simulator/sensor bench/evaluation bench/evaluation/score bench/evaluation/truth"
    "cli/text: transport"
    "cli/maps: transport map cli/text"
    "cli/query: map picture cli/text"
    "cli/upload: upload map dataset cli/text cli/maps"
    "cli/watch: watch map cli/text cli/maps cli/query"
    "cli/bench: dataset bench/simulator bench/simulator/routes bench/evaluation bench/evaluation/composite bench/evaluation/fleet bench/evaluation/method bench/evaluation/report bench/evaluation/room cli/text cli/upload"
    "cli: transport cli/text cli/maps cli/query cli/upload cli/watch cli/bench")
set(client_TOP_FILES "")

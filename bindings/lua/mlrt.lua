-- SPDX-License-Identifier: MIT
--
-- Where do rays hit triangles: the exact answers of libmlrt, for LuaJIT's FFI arrays.
--
--     local mlrt = require "mlrt"
--     local tree = mlrt.tree{vertices = floats, indices = numbers}     -- float[3 n], uint32_t[3 m]
--     local hits = tree:trace(origins, directions)                     -- float[3 k] each
--     print(hits.t[0], hits.triangle[0])
--     tree:close()                                                     -- or leave it to the garbage collector
--
-- FFI arrays go in and come out without a copy; Lua tables are copied into one first. All arrays count from 0. The
-- library is $MLRT_LIBRARY, or else what the system finds as libmlrt.so.0.

local ffi = require "ffi"

-- mlrt.h, as far as needed here.
ffi.cdef[[
typedef struct mlrt_tree mlrt_tree;
typedef struct mlrt_pool mlrt_pool;
typedef struct mlrt_array { void *data; size_t stride, row_stride; } mlrt_array;
typedef struct mlrt_const_array { const void *data; size_t stride; } mlrt_const_array;
typedef struct mlrt_mesh {
    uint32_t struct_size, id;
    const void *vertices; size_t vertex_count, vertex_stride;
    const void *indices; size_t triangle_count, triangle_stride;
    uint32_t index_size, mask;
} mlrt_mesh;
typedef struct mlrt_tree_options {
    uint32_t struct_size; int32_t preset;
    float traversal_cost, intersection_cost;
    char *message; size_t message_size;
    const void *host; uint64_t memory_limit;
    mlrt_pool *pool;
} mlrt_tree_options;
typedef struct mlrt_trace_options {
    uint32_t struct_size; int32_t query, method, isa, culling;
    uint32_t culling_check, initial_tile_size, minimum_tile_size, split_factor, outputs, shortcuts_off, mask;
    mlrt_pool *pool; void *counters; const void *host;
    const void *lights; uint32_t light_count, reserved;
} mlrt_trace_options;
typedef struct mlrt_hits {
    uint32_t struct_size, reserved;
    mlrt_array t, u, v, mesh, triangle, facing, occluded;
} mlrt_hits;
typedef struct mlrt_rays {
    uint32_t struct_size, row_length; size_t count;
    mlrt_const_array origins, directions, t_min, t_max, skip, mask;
    uint32_t rays_per_origin, reserved;
} mlrt_rays;
uint32_t mlrt_version(void);
void mlrt_struct_sizes(uint32_t *sizes, uint32_t count);
const char *mlrt_status_string(int32_t status);
int32_t mlrt_create_pool(uint32_t thread_count, mlrt_pool **pool);
void mlrt_destroy_pool(mlrt_pool *pool);
int32_t mlrt_build_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options, mlrt_tree **tree);
void mlrt_destroy_tree(mlrt_tree *tree);
int32_t mlrt_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options, const mlrt_hits *hits);
]]

local C = ffi.load(os.getenv "MLRT_LIBRARY" or "libmlrt.so.0")

-- Of the version that this file was written for, each layout must be the library's. The numbers are MLRT_STRUCT_*.
if C.mlrt_version() == 100 then
    local sizes = ffi.new "uint32_t[13]"
    C.mlrt_struct_sizes(sizes, 13)
    for name, place in pairs{mesh = 1, tree_options = 2, trace_options = 8, array = 9, hits = 10, const_array = 11, rays = 12} do
        assert(sizes[place] == ffi.sizeof("mlrt_" .. name), "mlrt: mlrt_" .. name .. " is not the library's")
    end
end

local mlrt = {NONE = 0xFFFFFFFF}

-- What errors of the library are raised as: tables with status (MLRT_ERROR_*) and message.
local Error = {__tostring = function(e) return e.message end}

local function check(status, details)
    if status == 0 then return end
    local message = ffi.string(C.mlrt_status_string(status))
    if details and details ~= "" then message = message .. ": " .. details end
    error(setmetatable({status = status, message = message}, Error), 0)
end

-- Does nothing: what is named in a call after another is not collected before. A struct's pointers don't count.
local function keep() end

local function struct(name)
    local s = ffi.new("mlrt_" .. name)
    s.struct_size = ffi.sizeof(s)
    return s
end

local pointer = {float = ffi.typeof "const float *", uint32_t = ffi.typeof "const uint32_t *"}

-- An array of triples and how many there are; what is not an FFI array of that type is an error, a table is copied.
local function triples(values, type, name)
    if _G.type(values) == "table" then values = ffi.new(type .. "[?]", #values, values) end
    local ok = _G.type(values) == "cdata" and pcall(pointer[type], values)
    if not ok or ffi.sizeof(values) % 12 ~= 0 then error(name .. ": " .. type .. "[3 n] or a table is needed", 0) end
    return values, ffi.sizeof(values) / 12
end

local function open(object)
    return object.handle or error("mlrt: used after close", 0)
end

-- Frees it now. Again does nothing.
local function closer(destroy)
    return function(object)
        if object.handle then destroy(ffi.gc(object.handle, nil)) end
        object.handle = nil
    end
end

local Pool, Tree = {close = closer(C.mlrt_destroy_pool)}, {close = closer(C.mlrt_destroy_tree)}
Pool.__index, Tree.__index = Pool, Tree

-- Threads that calls share their work with: `threads` at work, the calling one included; 0 = one per processor.
function mlrt.pool(threads)
    local out = ffi.new "mlrt_pool *[1]"
    check(C.mlrt_create_pool(threads or 0, out))
    return setmetatable({handle = ffi.gc(out[0], C.mlrt_destroy_pool)}, Pool)
end

-- A tree over meshes {vertices =, indices =, id =}. If all ids are 0 or missing, they become 0, 1, 2, ...
function mlrt.tree(...)
    local meshes, kept = {...}, {}
    local list = ffi.new("mlrt_mesh[?]", #meshes)
    for i, mesh in ipairs(meshes) do
        local vertices, vertex_count = triples(mesh.vertices, "float", "vertices")
        local indices, triangle_count = triples(mesh.indices, "uint32_t", "indices")
        kept[i] = {vertices, indices}
        list[i - 1] = {ffi.sizeof "mlrt_mesh", mesh.id or 0, vertices, vertex_count, 0, indices, triangle_count}
    end
    local out, message, options = ffi.new "mlrt_tree *[1]", ffi.new "char[256]", struct "tree_options"
    options.message, options.message_size = message, 256
    local status = C.mlrt_build_tree(list, #meshes, options, out)
    keep(kept)
    check(status, ffi.string(message))
    return setmetatable({handle = ffi.gc(out[0], C.mlrt_destroy_tree)}, Tree)
end

local function call(tree, origins, directions, pool, query, results)
    local rays, options, hits, arrays = struct "rays", struct "trace_options", struct "hits", {}
    local o, count = triples(origins, "float", "origins")
    local d, same = triples(directions, "float", "directions")
    if same ~= count then error("as many origins as directions are needed", 0) end
    rays.count, rays.origins.data, rays.directions.data = count, o, d
    options.query, options.pool = query, pool and open(pool) or nil
    for name, type in pairs(results) do
        arrays[name] = ffi.new(type, count)
        hits[name].data = arrays[name]
    end
    local status = C.mlrt_trace_packet(open(tree), rays, options, hits)
    keep(tree, pool, o, d)
    check(status)
    arrays.count = count
    return arrays
end

-- The closest hits {t, u, v, mesh, triangle, facing, count}, arrays with an element per ray. A miss has mesh = NONE.
function Tree:trace(origins, directions, pool)
    return call(self, origins, directions, pool, 0, {
        t = "float[?]", u = "float[?]", v = "float[?]", mesh = "uint32_t[?]", triangle = "uint32_t[?]", facing = "int32_t[?]",
    })
end

-- An array: 1 for each ray that hits anything, else 0.
function Tree:occluded(origins, directions, pool)
    return call(self, origins, directions, pool, 1, {occluded = "uint8_t[?]"}).occluded
end

return mlrt

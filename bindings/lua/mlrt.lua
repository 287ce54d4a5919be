-- SPDX-License-Identifier: MIT

--- Where do rays hit triangles: the exact answers of libmlrt, for LuaJIT's FFI arrays.
--
--     local mlrt = require "mlrt"
--     local tree = mlrt.build{vertices = floats, indices = numbers}                -- float[3 n], uint32_t[3 m]
--     local hits = tree:trace{origins = origins, directions = directions}          -- float[3 k] each
--     print(hits.t[0], hits.triangle[0])
--     tree:close()                                                                 -- or leave it to the garbage collector
--
-- All arrays count from 0. An array that goes in is
--
-- - an FFI array, which is used as it is,
-- - a Lua table, which is copied,
-- - a number, or `mlrt.all{...}`: one element for all,
-- - a table `{data = cdata, stride = bytes}`: elements elsewhere than one after the other. If `data` is a pointer, what it
--   points to is not checked.
--
-- Errors of the library are tables with `status` (a number of `mlrt.STATUS`) and `message`; printed, they are the message.
-- Wrong types and lengths, and closed objects, are strings.
--
-- The library is the first of: $MLRT_LIBRARY, the one that LuaRocks compiled, what the system finds as libmlrt.so.0.
-- @module mlrt

local has_ffi, ffi = pcall(require, "ffi")
if not has_ffi then error("mlrt: this is not LuaJIT, whose FFI is needed", 0) end
local bit = require "bit"

-- ---- the C interface: mlrt.h ---------------------------------------------------------------------------------------

ffi.cdef[[
typedef struct mlrt_tree mlrt_tree;
typedef struct mlrt_pool mlrt_pool;
typedef void *(*mlrt_allocate_callback)(void *user, size_t size, size_t alignment);
typedef void (*mlrt_free_callback)(void *user, void *block, size_t size, size_t alignment);
typedef void (*mlrt_log_callback)(void *user, int32_t level, const char *message);
typedef int32_t (*mlrt_progress_callback)(void *user, double fraction);
typedef void (*mlrt_task_function)(void *argument);
typedef void *(*mlrt_enqueue_callback)(void *user, mlrt_task_function function, void *argument);
typedef void (*mlrt_finish_callback)(void *user, void *task);
typedef struct mlrt_host {
    uint32_t struct_size, reserved; void *user;
    mlrt_allocate_callback allocate; mlrt_free_callback free; mlrt_log_callback log; mlrt_progress_callback progress;
} mlrt_host;
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
    const mlrt_host *host; uint64_t memory_limit;
    mlrt_pool *pool;
} mlrt_tree_options;
typedef struct mlrt_kdtree_options {
    uint32_t struct_size; int32_t preset;
    float traversal_cost, intersection_cost;
    char *message; size_t message_size;
    const mlrt_host *host; uint64_t memory_limit, max_references;
    uint32_t max_depth, rules_off;
    mlrt_pool *pool;
} mlrt_kdtree_options;
typedef struct mlrt_memory_estimate {
    uint32_t struct_size, reserved; uint64_t memory_size, peak_memory_size;
} mlrt_memory_estimate;
typedef struct mlrt_tree_info {
    uint32_t struct_size, depth;
    uint64_t triangle_count, non_finite_count, zero_area_count, node_count, leaf_count, empty_leaf_count, reference_count,
        retracted_count, memory_size, peak_memory_size, tree_hash;
    double sah_cost, build_seconds;
    float bounds_min[3], bounds_max[3];
    uint32_t structure, reserved;
} mlrt_tree_info;
typedef struct mlrt_load_options {
    uint32_t struct_size, flags; uint64_t geometry_hash, memory_limit;
    char *message; size_t message_size;
    const mlrt_host *host;
} mlrt_load_options;
typedef struct mlrt_pool_options {
    uint32_t struct_size, thread_count;
    const mlrt_host *host; void *user;
    mlrt_enqueue_callback enqueue; mlrt_finish_callback finish;
} mlrt_pool_options;
typedef struct mlrt_counters {
    uint32_t struct_size, reserved;
    uint64_t ray_count, packet_count, beam_count, cell_count, entry_point_cell_count, triangle_test_count, judged_lane_count,
        entry_point_count, entry_point_depth_sum, missed_beam_count, covered_beam_count, undecided_cull_count,
        undecided_checked_count, lane_test_count, undecided_test_count, tie_lane_count, exact_edge_count, exact_range_count,
        exact_order_count;
} mlrt_counters;
typedef struct mlrt_light { uint32_t struct_size; int32_t kind; float position[3]; } mlrt_light;
typedef struct mlrt_trace_options {
    uint32_t struct_size; int32_t query, method, isa, culling;
    uint32_t culling_check, initial_tile_size, minimum_tile_size, split_factor, outputs, shortcuts_off, mask;
    mlrt_pool *pool; mlrt_counters *counters; const mlrt_host *host;
    const mlrt_light *lights; uint32_t light_count, reserved;
} mlrt_trace_options;
typedef struct mlrt_array { void *data; size_t stride, row_stride; } mlrt_array;
typedef struct mlrt_hits {
    uint32_t struct_size, reserved;
    mlrt_array t, u, v, mesh, triangle, facing, occluded;
} mlrt_hits;
typedef struct mlrt_const_array { const void *data; size_t stride; } mlrt_const_array;
typedef struct mlrt_rays {
    uint32_t struct_size, row_length; size_t count;
    mlrt_const_array origins, directions, t_min, t_max, skip, mask;
    uint32_t rays_per_origin, reserved;
} mlrt_rays;
typedef struct mlrt_ray {
    uint32_t struct_size, flags;
    float origin[3], direction[3], t_min, t_max;
    uint32_t skip_mesh, skip_triangle;
} mlrt_ray;
typedef struct mlrt_hit {
    uint32_t struct_size; float t, u, v; uint32_t mesh, triangle; int32_t facing; uint32_t occluded;
} mlrt_hit;
typedef struct mlrt_hit_lists {
    uint32_t struct_size, capacity;
    mlrt_array t, u, v, mesh, triangle, facing, crossing, total, crossing_total;
} mlrt_hit_lists;
typedef struct mlrt_camera {
    uint32_t struct_size; int32_t projection;
    uint32_t width, height, crop_x, crop_y, crop_width, crop_height;
    float eye[3], direction[3], d00[3], dx[3], dy[3], sample_x, sample_y, t_min, t_max;
} mlrt_camera;
typedef struct mlrt_tile {
    uint32_t struct_size, worker, x, y, width, height;
    const float *t, *u, *v; const uint32_t *mesh, *triangle; const int32_t *facing; const uint8_t *occluded;
} mlrt_tile;
typedef struct mlrt_points {
    uint32_t struct_size, row_length; size_t count;
    mlrt_const_array positions, skip;
} mlrt_points;
typedef int32_t (*mlrt_tile_callback)(void *user, const mlrt_tile *tile);
uint32_t mlrt_version(void);
uint64_t mlrt_capabilities(void);
void mlrt_struct_sizes(uint32_t *sizes, uint32_t count);
const char *mlrt_status_string(int32_t status);
const char *mlrt_last_message(void);
int32_t mlrt_create_pool(uint32_t thread_count, mlrt_pool **pool);
int32_t mlrt_create_pool_with_options(const mlrt_pool_options *options, mlrt_pool **pool);
uint32_t mlrt_pool_thread_count(const mlrt_pool *pool);
void mlrt_destroy_pool(mlrt_pool *pool);
int32_t mlrt_build_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options, mlrt_tree **tree);
int32_t mlrt_build_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options, mlrt_tree **tree);
void mlrt_destroy_tree(mlrt_tree *tree);
int32_t mlrt_estimate_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options, mlrt_memory_estimate *estimate);
int32_t mlrt_estimate_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options, mlrt_memory_estimate *estimate);
int32_t mlrt_get_tree_info(const mlrt_tree *tree, mlrt_tree_info *info);
int32_t mlrt_save_tree(const mlrt_tree *tree, void *buffer, size_t capacity, size_t *size);
int32_t mlrt_load_tree(const void *data, size_t size, const mlrt_load_options *options, mlrt_tree **tree);
int32_t mlrt_hash_geometry(const mlrt_mesh *meshes, size_t mesh_count, uint64_t *hash);
int32_t mlrt_trace_packet(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options, const mlrt_hits *hits);
int32_t mlrt_trace_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_trace_options *options, mlrt_hit *hit);
int32_t mlrt_trace_all_hits(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options, const mlrt_hit_lists *lists);
int32_t mlrt_render_tiles(const mlrt_tree *tree, const mlrt_camera *camera, const mlrt_trace_options *options, const mlrt_hits *frame, mlrt_tile_callback callback, void *user);
int32_t mlrt_camera_rays(const mlrt_camera *camera, const mlrt_array *origins, const mlrt_array *directions);
int32_t mlrt_occluded_points(const mlrt_tree *tree, const mlrt_points *points, const mlrt_light *light, const mlrt_trace_options *options, const mlrt_array *occluded);
int32_t mlrt_shadow_ray(const mlrt_tree *tree, const mlrt_ray *ray, const mlrt_hit *hit, const mlrt_light *light, mlrt_ray *shadow, int32_t *faces);
int32_t mlrt_offset_point(const mlrt_tree *tree, uint32_t mesh, uint32_t triangle, float u, float v, int32_t side, float point[3]);
]]

local function load_library()
    local given = os.getenv "MLRT_LIBRARY"
    local compiled = package.searchpath("mlrt.native", package.cpath)
    local found, library = pcall(ffi.load, given or compiled or "libmlrt.so.0")
    if found then return library end
    error("mlrt: the library is not there (" .. tostring(library) .. "): install it by `luarocks install mlrt`, which compiles "
        .. "it, or by `make install` of libmlrt, or put the path of its file into the variable MLRT_LIBRARY", 0)
end

local C = load_library()

-- Of the version that this file was written for, each layout must be the library's. In the order of MLRT_STRUCT_*.
local structs = {
    "host", "mesh", "tree_options", "tree_info", "memory_estimate", "load_options", "pool_options", "counters", "trace_options",
    "array", "hits", "const_array", "rays", "ray", "hit", "hit_lists", "camera", "tile", "light", "points", "kdtree_options",
}
if C.mlrt_version() == 100 then
    local sizes = ffi.new("uint32_t[?]", #structs)
    C.mlrt_struct_sizes(sizes, #structs)
    for place, name in ipairs(structs) do
        if sizes[place - 1] ~= ffi.sizeof("mlrt_" .. name) then error("mlrt: mlrt_" .. name .. " is not the library's", 0) end
    end
end

--- The C functions, for those who want to call them: `mlrt.C.mlrt_version()`.
local mlrt = {C = C}

--- Mesh and triangle of a miss.
mlrt.NONE = 0xFFFFFFFF

--- What `status` of an error can be.
mlrt.STATUS = {
    OK = 0, ARGUMENT = 1, STRUCT_SIZE = 2, INDEX_RANGE = 3, OUT_OF_MEMORY = 4, TOO_LARGE = 5, CAMERA = 6, UNSUPPORTED = 7,
    THREAD = 8, CANCELLED = 9, DATA = 10,
}

--- Rules of the kd-tree's builder, for `rules_off`, or-ed together.
mlrt.RULE = {EMPTY_SPACE = 1, COPLANAR = 2, MINIMUM_CELL = 4, CLIPPED_SPLITS = 8, RETRACTION = 16}

--- Shortcuts of method multilevel, for `shortcuts_off`, or-ed together.
mlrt.SHORTCUT = {WHOLE_TILES = 1, ENTRY_LISTS = 2, SHARED_SETUPS = 4}

local methods = {default = 0, ray = 1, packet2 = 2, packet4 = 3, multilevel = 4, tile = 5}
local isas = {auto = 0, scalar = 1, sse = 2, avx2 = 3, avx512 = 4, neon = 5}
local cullings = {inverse = 0, direct = 1}
local queries = {closest = 0, any = 1}
local presets = {default = 0, fast = 1, best = 2}
local kdtree_presets = {paper = 0, tuned = 1}
local projections = {pinhole = 0, parallel = 1}
local light_kinds = {point = 0, directional = 1}
local levels = {[0] = "error", "warning", "info"}
local tile_outputs = {t = 1, uv = 2, ids = 4, facing = 8, triangle = 16, occluded = 32}

-- ---- errors --------------------------------------------------------------------------------------------------------

local Error = {__tostring = function(e) return e.message end}

local function raise(status, message)
    error(setmetatable({status = status, message = message}, Error), 0)
end

local function check(status)
    if status == 0 then return end
    local message = ffi.string(C.mlrt_last_message())
    raise(status, message ~= "" and message or ffi.string(C.mlrt_status_string(status)))
end

--- What a status means.
-- @param status a number
-- @return an English phrase
function mlrt.status_string(status)
    return ffi.string(C.mlrt_status_string(status))
end

-- ---- arguments -----------------------------------------------------------------------------------------------------

-- Does nothing: what is named in a call after another is not collected before. A struct's pointers don't count.
local function keep() end

local function struct(name)
    local s = ffi.new("mlrt_" .. name)
    s.struct_size = ffi.sizeof(s)
    return s
end

-- The number of a word.
local function choose(words, word, name)
    return words[word] or error(name .. ": there is no " .. tostring(word), 0)
end

local pointers = {float = ffi.typeof "const float *", double = ffi.typeof "const double *", uint32_t = ffi.typeof "const uint32_t *", int32_t = ffi.typeof "const int32_t *",
    uint8_t = ffi.typeof "const uint8_t *", uint16_t = ffi.typeof "const uint16_t *"}

local function is_array(value)
    return type(value) == "cdata" and tostring(ffi.typeof(value)):find("[", 1, true) ~= nil
end

-- Whether it is an FFI array or a pointer, but not NULL. ffi.cast would take numbers and strings for addresses too.
local function is_memory(value)
    return value ~= nil and type(value) == "cdata" and tostring(ffi.typeof(value)):find "[%[%*]" ~= nil
end

-- LuaJIT's arrays have less than 2 GB. Of the length of a longer one ffi.new may take the low 32 bits.
local function new_array(ctype, length, name)
    if length * ffi.sizeof(ctype) >= 2^31 then
        error(name .. ": " .. length .. " elements are more than an FFI array can have", 0)
    end
    return ffi.new(ctype .. "[?]", length)
end

local WORD, SIZE = 2^32 - 1, 2^53 -- the greatest of a uint32_t, and of a size_t that is exact

-- A whole number from 0 to `most`: C would take another one for it. nil is `default`.
local function whole(value, most, name, default)
    if value == nil then return default or 0 end
    local number = tonumber(value)
    if not number or number % 1 ~= 0 or number < 0 or number > most then
        error(name .. ": " .. tostring(value) .. " is not a whole number from 0 to " .. (most == WORD and "2^32 - 1" or "2^53"), 0)
    end
    return number
end

-- Bits, which may be those of a negative number: functions of `bit` return such.
local function bits(value, name)
    if type(value) == "number" and value < 0 and value >= -2^31 then value = value % 2^32 end
    return whole(value, WORD, name)
end

-- The numbers of a table in an FFI array. ffi.new would end at the first nil, and take other words for what is none.
local function copied(values, ctype, name)
    local array = new_array(ctype, #values, name)
    for place = 1, #values do
        local value = values[place]
        local number = type(value) ~= "string" and tonumber(value)
        if not number then error(name .. ": a number is needed, not " .. tostring(value), 0) end
        if name == "rays.mask" then
            number = bits(number, name)
        elseif ctype ~= "float" then
            number = whole(number, WORD, name)
        end
        array[place - 1] = number
    end
    return array
end

local function vector(target, values, name)
    if type(values) == "table" then
        if #values ~= 3 then error(name .. ": three numbers are needed, not " .. #values, 0) end
        values = copied(values, "float", name)
    end
    local size = values ~= nil and (pcall(pointers.float, values) and 4 or pcall(pointers.double, values) and 8)
    if not size then error(name .. ": three numbers are needed, in a table, float[3] or double[3]", 0) end
    if is_array(values) and ffi.sizeof(values) < 3 * size then
        error(name .. ": three numbers are needed, not " .. ffi.sizeof(values) .. " bytes", 0)
    end
    for k = 0, 2 do target[k] = values[k] end
end

local All = {}

--- One element for all rays or points.
-- @param element its numbers, in a table: `mlrt.all{0, 0, 1}`
-- @return a value for any array that goes in
function mlrt.all(element)
    if type(element) ~= "table" then error("mlrt.all: a table of numbers is needed, not " .. tostring(element), 0) end
    return setmetatable({element = element}, All)
end

local STRIDE_ALL = ffi.cast("size_t", 0xFFFFFFFFFFFFFFFFULL)

-- Memory of a stride, and how many bytes of it are needed.
local function check_room(data, needed, name)
    if is_array(data) and ffi.sizeof(data) < needed then
        error(name .. ": " .. ffi.sizeof(data) .. " bytes are too few, " .. needed .. " are needed", 0)
    end
end

-- Where the elements of an array of a call lie: `count` of `size` bytes, `step` bytes apart.
local function place_of(data, count, step, size)
    if step == size then count, size = 1, count * size end -- without gaps: like one element
    local start = tonumber(ffi.cast("uintptr_t", ffi.cast("const void *", data)))
    return {start = start, count = count, step = step, size = size}
end

-- Whether two arrays have bytes in common. Of different strides with gaps it is not known: then false.
local function meet(a, b)
    if a.count * b.count == 0 or a.size * b.size == 0 then return false end
    if a.count > 1 and b.count > 1 and a.step ~= b.step then return false end
    local step, distance = a.count > 1 and a.step or b.step, b.start - a.start
    -- The first of b's elements, seen from one of a's, that ends behind its begin: does it begin before its end?
    local k = math.max(1 - a.count, math.floor((-b.size - distance) / step) + 1)
    return k < b.count and distance + k * step < a.size
end

-- How many elements of `width` numbers a packed array has; nil if that can't be told.
local function count_of(value, width)
    if is_array(value) then return math.floor(ffi.sizeof(value) / (4 * width)) end
    if type(value) == "table" and getmetatable(value) ~= All and value.data == nil then return math.floor(#value / width) end
end

-- Writes an input array of `count` elements, `width` numbers each, to a field; `kept` keeps it from being collected.
local function input(field, value, ctype, width, count, name, kept)
    if value == nil then return end
    if type(value) == "number" then value = mlrt.all{value} end
    if type(value) == "table" and getmetatable(value) == All then
        if #value.element ~= width then error(name .. ": one element for all has " .. width .. " numbers, not " .. #value.element, 0) end
        value = {data = copied(value.element, ctype, name), stride = STRIDE_ALL}
    elseif type(value) == "table" and value.data ~= nil then
        local stride = whole(value.stride, SIZE, name .. ", stride")
        if not is_memory(value.data) then error(name .. ": data: an FFI array or a pointer is needed", 0) end
        check_room(value.data, count == 0 and 0 or (count - 1) * (stride > 0 and stride or 4 * width) + 4 * width, name)
    else
        if type(value) == "table" then value = copied(value, ctype, name) end
        if not is_array(value) or not pcall(pointers[ctype], value) then error(name .. ": " .. ctype .. "[], a table, a number or mlrt.all is needed", 0) end
        if ffi.sizeof(value) ~= 4 * width * count then
            error(name .. ": " .. ffi.sizeof(value) / 4 .. " numbers, but " .. width * count .. " are needed", 0)
        end
        value = {data = value, stride = 0}
    end
    field.data, field.stride = ffi.cast("const void *", value.data), value.stride or 0
    kept[#kept + 1] = value
    local step = tonumber(field.stride)
    local all = field.stride == STRIDE_ALL
    kept.places[name] = place_of(value.data, all and 1 or count, (all or step == 0) and 4 * width or step, 4 * width)
end

local result_types = {
    t = "float", u = "float", v = "float", mesh = "uint32_t", triangle = "uint32_t", facing = "int32_t", occluded = "uint8_t",
    crossing = "uint8_t", total = "uint32_t", crossing_total = "uint32_t",
}
local closest = {"t", "u", "v", "mesh", "triangle", "facing"}
local writable = {
    float = ffi.typeof "float *", uint32_t = ffi.typeof "uint32_t *", int32_t = ffi.typeof "int32_t *",
    uint8_t = ffi.typeof "uint8_t *",
}

-- Makes arrays for results, or takes those of `options.into`, and writes them to the fields of a struct. `size(name)`
-- gives columns and rows.
local function results(target, options, allowed, size, read)
    local arrays, wanted, into, places = {}, {}, options.into or {}, {}
    for _, name in ipairs(options.outputs or (options.into and {}) or allowed) do wanted[name] = true end
    for name in pairs(into) do wanted[name] = true end
    for _, name in ipairs(allowed) do
        if wanted[name] then
            local columns, rows = size(name)
            local ctype, value = result_types[name], into[name]
            local bytes = ffi.sizeof(ctype)
            if value == nil then value = new_array(ctype, columns * rows, name) end
            local given = type(value) == "table" and value or {data = value}
            local stride = whole(given.stride, SIZE, "into." .. name .. ", stride")
            local row_stride = whole(given.row_stride, SIZE, "into." .. name .. ", row_stride")
            if stride == 0 then stride = bytes end
            if row_stride == 0 then row_stride = stride * columns end
            if type(value) ~= "table" and not (is_array(value) and pcall(writable[ctype], value)) then
                error("into." .. name .. ": " .. ctype .. "[] is needed", 0)
            end
            if not is_memory(given.data) then
                error("into." .. name .. ": data: an FFI array or a pointer is needed", 0)
            end
            check_room(given.data, columns * rows == 0 and 0 or (rows - 1) * row_stride + (columns - 1) * stride + bytes, "into." .. name)
            target[name].data, target[name].stride = ffi.cast("void *", given.data), given.stride or 0
            target[name].row_stride = given.row_stride or 0
            arrays[name], wanted[name] = value, nil
            -- Rows with gaps between them count as one element each, if they have none within.
            local row = stride * columns
            if rows < 2 or row_stride == row then
                places[name] = place_of(given.data, columns * rows, stride, bytes)
            elseif stride == bytes then
                places[name] = place_of(given.data, rows, row_stride, row)
            end
        end
    end
    for name in pairs(into) do
        for other, place in pairs(places) do
            if places[name] and other ~= name and meet(places[name], place) then
                error("into." .. name .. ": it shares memory with " .. other, 0)
            end
        end
        for other, place in pairs(places[name] and read or {}) do
            if meet(places[name], place) then error("into." .. name .. ": it shares memory with " .. other, 0) end
        end
    end
    for name in pairs(wanted) do error("outputs: " .. tostring(name) .. " is not a result of this call", 0) end
    return arrays
end

local function open(object)
    return object.handle or error("mlrt: used after close", 0)
end

-- ---- calls ---------------------------------------------------------------------------------------------------------

-- A call with callbacks, which may not close what it uses. LuaJIT must not compile it, since they come back into Lua.
local function call(calls, used, f, ...)
    for _, object in pairs(used) do object.calls = object.calls + 1 end
    local ok, status = pcall(f, ...)
    for _, object in pairs(used) do object.calls = object.calls - 1 end
    if not ok then
        calls.free() -- as of a tree that is none
        error(status, 0)
    end
    return status
end
jit.off(call)

-- The callbacks of a call, each made for it alone: options.progress, options.log and, for pictures, options.on_tile.
local function callbacks(options)
    local self = {made = {}}
    local pool = options.pool
    for _, name in ipairs{"progress", "on_tile"} do
        if options[name] and pool and C.mlrt_pool_thread_count(open(pool)) ~= 1 then
            error("options." .. name .. ": with a pool, other threads would call it, which LuaJIT does not allow: leave out one of them", 0)
        end
    end
    -- Errors must not leave a callback: the first is kept, and raised after the call.
    local function guarded(f, stop)
        return function(user, ...)
            if self.failure then return stop end
            local ok, answer = pcall(f, ...)
            if not ok then self.failure = {answer} end
            return (not ok or answer == false) and stop or 0
        end
    end
    function self.free()
        for _, callback in ipairs(self.made) do callback:free() end
    end
    local function make(ctype, f)
        local made, callback = pcall(ffi.cast, ctype, f)
        if not made then -- there are too many
            self.free()
            error(callback, 0)
        end
        self.made[#self.made + 1] = callback
        return callback
    end
    if options.progress or options.log then
        self.host = struct "host"
        if options.progress then self.host.progress = make("mlrt_progress_callback", guarded(options.progress, 1)) end
        if options.log then
            local log = guarded(function(level, message) options.log(levels[level] or "info", ffi.string(message)) end)
            self.host.log = make("mlrt_log_callback", function(...) log(...) end)
        end
    end
    if options.on_tile then self.tile = make("mlrt_tile_callback", guarded(options.on_tile, 1)) end
    function self.finish(status)
        self.free()
        if self.failure then error(self.failure[1], 0) end
        check(status)
    end
    return self
end

local function trace_options(options, query)
    local s = struct "trace_options"
    s.query = query
    s.method = choose(methods, options.method or "default", "options.method")
    s.isa = choose(isas, options.isa or "auto", "options.isa")
    s.culling = choose(cullings, options.culling or "inverse", "options.culling")
    s.culling_check = options.culling_check and 1 or 0
    for _, name in ipairs{"initial_tile_size", "minimum_tile_size", "split_factor"} do
        s[name] = whole(options[name], WORD, "options." .. name)
    end
    s.shortcuts_off, s.mask = bits(options.shortcuts_off, "options.shortcuts_off"), bits(options.mask, "options.mask")
    s.pool = options.pool and open(options.pool) or nil
    local counters = options.counters
    if counters and not ffi.istype("mlrt_counters", counters.struct) then
        error("options.counters: mlrt.counters() is needed", 0)
    end
    s.counters = counters and counters.struct or nil
    return s
end

-- ---- handles -------------------------------------------------------------------------------------------------------

-- Frees it now. Again does nothing.
local function closer(destroy)
    return function(object)
        if object.calls > 0 then error("mlrt: closed during a call that uses it", 0) end
        if object.handle then destroy(ffi.gc(object.handle, nil)) end
        object.handle = nil
    end
end

--- Threads that calls share their work with.
-- @type Pool
local Pool = {close = closer(C.mlrt_destroy_pool)}
--- Triangles, and what finds them. Never changes.
-- @type Tree
local Tree = {close = closer(C.mlrt_destroy_tree)}
Pool.__index, Tree.__index = Pool, Tree

--- Makes a pool.
-- @param threads how many are at work, the calling one included, 1..1024; nil or 0 = one per processor
-- @return a pool, freed by `pool:close()` or the garbage collector
function mlrt.pool(threads)
    local out = ffi.new "mlrt_pool *[1]"
    check(C.mlrt_create_pool(whole(threads, WORD, "threads"), out))
    return setmetatable({handle = ffi.gc(out[0], C.mlrt_destroy_pool), calls = 0}, Pool)
end

--- How many threads are at work, the calling one included.
-- @return their number, at least 1
function Pool:threads()
    return C.mlrt_pool_thread_count(open(self))
end

-- `data`, which may be nil, is kept as long as the tree.
local function new_tree(handle, data)
    local function destroy(tree)
        C.mlrt_destroy_tree(tree)
        keep(data)
    end
    return setmetatable({handle = ffi.gc(handle, data and destroy or C.mlrt_destroy_tree), data = data, calls = 0}, Tree)
end

-- ---- building ------------------------------------------------------------------------------------------------------

-- An array of triples of a mesh, how many there are, the stride, and the bytes of an index.
local function triples(value, stride, count, ctypes, name)
    local ctype
    if type(value) == "table" then
        ctype = ctypes[1]
        value = copied(value, ctype, name)
    end
    for _, candidate in ipairs(ctypes) do
        if type(value) == "cdata" and not ctype and pcall(pointers[candidate], value) then ctype = candidate end
    end
    if not ctype or not (is_array(value) or count) then error(name .. ": " .. ctypes[1] .. "[3 n] or a table is needed", 0) end
    local size = 3 * ffi.sizeof(ctype)
    stride = whole(stride, SIZE, name .. ", stride")
    count = count and whole(count, SIZE, name .. ", count")
    if is_array(value) and stride == 0 and not count and ffi.sizeof(value) % size ~= 0 then
        error(name .. ": " .. ctypes[1] .. "[3 n] or a table is needed", 0)
    end
    local step = stride > 0 and stride or size
    count = count or math.max(0, math.floor((ffi.sizeof(value) - size) / step) + 1)
    check_room(value, count == 0 and 0 or (count - 1) * step + size, name)
    return value, count, stride, ffi.sizeof(ctype)
end

local function mesh_list(meshes)
    if meshes.vertices then meshes = {meshes} end
    local kept, list = {}, ffi.new("mlrt_mesh[?]", #meshes)
    for i, mesh in ipairs(meshes) do
        local target, name = list[i - 1], "meshes[" .. i - 1 .. "]."
        target.struct_size, target.id, target.mask = ffi.sizeof "mlrt_mesh", whole(mesh.id, WORD, name .. "id"), bits(mesh.mask, name .. "mask")
        local vertices, count, stride = triples(mesh.vertices, mesh.vertex_stride, mesh.vertex_count, {"float"}, name .. "vertices")
        target.vertices, target.vertex_count, target.vertex_stride = vertices, count, stride
        target.triangle_count = whole(mesh.triangle_count, SIZE, name .. "triangle_count", math.floor(count / 3))
        kept[#kept + 1] = vertices
        if mesh.indices then
            local indices, triangles, step, size = triples(mesh.indices, mesh.triangle_stride, mesh.triangle_count, {"uint32_t", "uint16_t"}, name .. "indices")
            target.indices, target.triangle_count, target.triangle_stride, target.index_size = indices, triangles, step, size
            kept[#kept + 1] = indices
        end
    end
    return list, #meshes, kept
end

local function tree_options(options)
    local s = struct "tree_options"
    s.preset = choose(presets, options.preset or "default", "options.preset")
    s.traversal_cost, s.intersection_cost = options.traversal_cost or 0, options.intersection_cost or 0
    s.memory_limit = whole(options.memory_limit, SIZE, "options.memory_limit")
    s.pool = options.pool and open(options.pool) or nil
    return s
end

local function kdtree_options(options)
    local s = struct "kdtree_options"
    s.preset = choose(kdtree_presets, options.preset or "paper", "options.preset")
    s.traversal_cost, s.intersection_cost = options.traversal_cost or 0, options.intersection_cost or 0
    for _, name in ipairs{"memory_limit", "max_references"} do s[name] = whole(options[name], SIZE, "options." .. name) end
    s.max_depth, s.rules_off = whole(options.max_depth, WORD, "options.max_depth"), bits(options.rules_off, "options.rules_off")
    s.pool = options.pool and open(options.pool) or nil
    return s
end

local function build(builder, make_options, meshes, options)
    local list, count, kept = mesh_list(meshes)
    local out, settings = ffi.new "mlrt_tree *[1]", make_options(options)
    local calls = callbacks(options)
    settings.host = calls.host
    local status = call(calls, {options.pool}, builder, list, count, settings, out)
    keep(kept, options)
    local tree = out[0] ~= nil and new_tree(out[0]) or nil
    calls.finish(status)
    return tree
end

--- Builds the best tree there is, a hierarchy of boxes.
-- @param meshes a mesh or a list of them, `{vertices =, indices =, id =, mask =, vertex_stride =, triangle_stride =}`:
--   float[3 n]; uint32_t[3 m], uint16_t[3 m] or nil. If all ids are 0 or missing, they become 0, 1, 2, ...
-- @param options nil or a table: preset ("default", "fast", "best"), traversal_cost, intersection_cost, memory_limit, pool,
--   progress = function(fraction), which may return false to stop (not with a pool), log = function(level, message)
-- @return a tree, freed by `tree:close()` or the garbage collector
function mlrt.build(meshes, options)
    return build(C.mlrt_build_tree, tree_options, meshes, options or {})
end

--- Builds the paper's kd-tree, for study.
-- @param meshes as in `mlrt.build`
-- @param options as in `mlrt.build`, but preset ("paper", "tuned"), and max_references, max_depth, rules_off
-- @return a tree
function mlrt.build_kdtree(meshes, options)
    return build(C.mlrt_build_kdtree, kdtree_options, meshes, options or {})
end

--- Loads a saved tree.
-- @param data what `tree:save()` returned, or an FFI array of bytes
-- @param options nil or a table: geometry_hash, memory_limit, log, size (in bytes, if `data` is a pointer, for example to a
--   mapped file), in_place = true: use the bytes where they lie, if their address is a multiple of 64; they must not change,
--   and what a pointer points to must not be freed, until the tree is closed
-- @return a tree
function mlrt.load(data, options)
    options = options or {}
    local s, out = struct "load_options", ffi.new "mlrt_tree *[1]"
    local hash = options.geometry_hash
    s.flags = options.in_place and 1 or 0
    s.geometry_hash = type(hash) == "cdata" and hash or whole(hash, SIZE, "options.geometry_hash")
    s.memory_limit = whole(options.memory_limit, SIZE, "options.memory_limit")
    local there = type(data) == "string" and #data or is_array(data) and ffi.sizeof(data)
    local size = options.size and whole(options.size, SIZE, "options.size") or there
    if not size or not there and not is_memory(data) then
        error("data: a string, an FFI array, or a pointer and options.size are needed", 0)
    end
    if there and size > there then error("options.size: " .. size .. " bytes, but data has " .. there, 0) end
    local calls = callbacks{log = options.log}
    s.host = calls.host
    local status = call(calls, {}, C.mlrt_load_tree, ffi.cast("const void *", data), size, s, out)
    local tree = out[0] ~= nil and new_tree(out[0], options.in_place and data or nil) or nil
    keep(data)
    calls.finish(status)
    return tree
end

--- The bytes from which `mlrt.load` makes the same tree.
-- @return a string
function Tree:save()
    local size = ffi.new "size_t[1]"
    check(C.mlrt_save_tree(open(self), nil, 0, size))
    local bytes = new_array("uint8_t", tonumber(size[0]), "save")
    check(C.mlrt_save_tree(open(self), bytes, size[0], size))
    return ffi.string(bytes, size[0])
end

--- The build report: the fields of mlrt_tree_info. Counts are numbers, tree_hash is a uint64_t.
-- @return a table
function Tree:info()
    local s = struct "tree_info"
    check(C.mlrt_get_tree_info(open(self), s))
    local info = {
        structure = s.structure == 1 and "kdtree" or "bvh", tree_hash = s.tree_hash, depth = s.depth, sah_cost = s.sah_cost,
        build_seconds = s.build_seconds, bounds_min = {s.bounds_min[0], s.bounds_min[1], s.bounds_min[2]},
        bounds_max = {s.bounds_max[0], s.bounds_max[1], s.bounds_max[2]},
    }
    for _, name in ipairs{"triangle_count", "non_finite_count", "zero_area_count", "node_count", "leaf_count", "empty_leaf_count",
        "reference_count", "retracted_count", "memory_size", "peak_memory_size"} do
        info[name] = tonumber(s[name])
    end
    return info
end

local function estimate(f, meshes, options)
    local list, count, kept = mesh_list(meshes)
    local s = struct "memory_estimate"
    check(f(list, count, options, s))
    keep(kept)
    return {memory_size = tonumber(s.memory_size), peak_memory_size = tonumber(s.peak_memory_size)}
end

--- The memory that `mlrt.build` will take, from the numbers of triangles alone.
-- @return a table: memory_size, peak_memory_size
function mlrt.estimate_tree(meshes, options)
    return estimate(C.mlrt_estimate_tree, meshes, tree_options(options or {}))
end

--- The memory that `mlrt.build_kdtree` will take: a guess, which can be off by a factor of two.
-- @return a table: memory_size, peak_memory_size
function mlrt.estimate_kdtree(meshes, options)
    return estimate(C.mlrt_estimate_kdtree, meshes, kdtree_options(options or {}))
end

--- A hash of meshes, by which a saved tree can be known to be theirs.
-- @return a uint64_t
function mlrt.hash_geometry(meshes)
    local list, count, kept = mesh_list(meshes)
    local hash = ffi.new "uint64_t[1]"
    check(C.mlrt_hash_geometry(list, count, hash))
    keep(kept)
    return hash[0]
end

-- ---- many rays -----------------------------------------------------------------------------------------------------

local function rays_struct(rays, kept)
    local s, k = struct "rays", math.max(1, whole(rays.rays_per_origin, WORD, "rays.rays_per_origin"))
    local groups = count_of(rays.origins, 3)
    local count = rays.count or count_of(rays.directions, 3) or count_of(rays.t_max, 1) or count_of(rays.mask, 1) or groups and groups * k
    if not count then error("rays.count: it is needed, since no array of rays is packed", 0) end
    count = whole(count, SIZE, "rays.count")
    groups = math.floor(count / k)
    s.count, s.rays_per_origin, s.row_length = count, k, whole(rays.row_length, WORD, "rays.row_length")
    input(s.origins, rays.origins, "float", 3, groups, "rays.origins", kept)
    input(s.directions, rays.directions, "float", 3, count, "rays.directions", kept)
    input(s.t_min, rays.t_min, "float", 1, groups, "rays.t_min", kept)
    input(s.t_max, rays.t_max, "float", 1, count, "rays.t_max", kept)
    input(s.skip, rays.skip, "uint32_t", 2, groups, "rays.skip", kept)
    input(s.mask, rays.mask, "uint32_t", 1, count, "rays.mask", kept)
    return s, count
end

local function trace(tree, rays, options, query, allowed)
    local kept, hits = {places = {}}, struct "hits"
    local list, count = rays_struct(rays, kept)
    local arrays = results(hits, options, allowed, function() return count, 1 end, kept.places)
    local settings, handle = trace_options(options, query), open(tree)
    local calls = callbacks(options)
    settings.host = calls.host
    local status = call(calls, {tree, options.pool}, C.mlrt_trace_packet, handle, list, settings, hits)
    keep(tree, options, kept, arrays)
    calls.finish(status)
    arrays.count = count
    return arrays
end

--- The closest hit of each ray.
-- @param rays a table: origins, directions (three floats each), t_min, t_max, skip (mesh and triangle), mask,
--   rays_per_origin, row_length, count (where no packed array tells it)
-- @param options nil or a table: method ("ray", "packet2", "packet4", "multilevel", "tile"), isa ("scalar", "sse", "avx2",
--   "avx512", "neon"), culling ("inverse", "direct"), culling_check, initial_tile_size, minimum_tile_size, split_factor,
--   shortcuts_off, mask, pool, counters, progress, log as in `mlrt.build`, outputs = a list of the results that are wanted,
--   into = a table of the arrays that they are written to, each an FFI array or `{data =, stride =}`, which share
--   memory neither with each other nor with anything that the call reads
-- @return a table: t, u, v, mesh, triangle, facing, arrays with an element per ray, and count. A miss has mesh = NONE
function Tree:trace(rays, options)
    return trace(self, rays, options or {}, queries.closest, closest)
end

--- Whether rays hit anything.
-- @param rays as in `tree:trace`
-- @param options as in `tree:trace`
-- @return an array: 1 for each ray that does, else 0
function Tree:occluded(rays, options)
    return trace(self, rays, options or {}, queries.any, {"occluded"}).occluded
end

--- Every triangle that each ray hits, nearest first.
-- @param rays as in `tree:trace`
-- @param options as in `tree:trace`, and capacity: most hits per ray; nil or 0 = only the totals
-- @return a table: t, u, v, mesh, triangle, facing, crossing with `capacity` elements per ray; total, crossing_total
function Tree:all_hits(rays, options)
    options = options or {}
    local kept, lists, capacity = {places = {}}, struct "hit_lists", whole(options.capacity, WORD, "options.capacity")
    local list, count = rays_struct(rays, kept)
    local allowed = {"total", "crossing_total"}
    if capacity > 0 then allowed = {"t", "u", "v", "mesh", "triangle", "facing", "crossing", "total", "crossing_total"} end
    lists.capacity = capacity
    local function size(name) return name:find "total" and count or count * capacity, 1 end
    local arrays = results(lists, options, allowed, size, kept.places)
    local settings, handle = trace_options(options, queries.closest), open(self)
    local calls = callbacks(options)
    settings.host = calls.host
    local status = call(calls, {self, options.pool}, C.mlrt_trace_all_hits, handle, list, settings, lists)
    keep(options, kept, arrays)
    calls.finish(status)
    arrays.count = count
    return arrays
end

-- ---- pictures and light --------------------------------------------------------------------------------------------

local function camera_struct(camera)
    local s, crop, sample = struct "camera", camera.crop or {}, camera.sample or {0.5, 0.5}
    s.projection = choose(projections, camera.projection or "pinhole", "camera.projection")
    for _, name in ipairs{"width", "height"} do s[name] = whole(camera[name], WORD, "camera." .. name) end
    for _, name in ipairs{"x", "y", "width", "height"} do s["crop_" .. name] = whole(crop[name], WORD, "camera.crop." .. name) end
    for _, name in ipairs{"eye", "direction", "d00", "dx", "dy"} do
        vector(s[name], camera[name] or {0, 0, 0}, "camera." .. name)
    end
    s.sample_x, s.sample_y, s.t_min, s.t_max = sample[1], sample[2], camera.t_min or 0, camera.t_max or 0
    local columns = s.crop_width > 0 and s.crop_width or math.max(0, s.width - s.crop_x)
    return s, columns, s.crop_height > 0 and s.crop_height or math.max(0, s.height - s.crop_y)
end

local function write_light(target, light, name)
    target.struct_size = ffi.sizeof "mlrt_light"
    target.kind = choose(light_kinds, light.kind or "point", name .. ".kind")
    vector(target.position, light.position, name .. ".position")
end

--- A pinhole camera that looks at a point, in the middle of the picture.
-- @param view a table: eye, target, up ({0, 1, 0}), fov (the height of the picture in degrees: 45), width, height
-- @return a camera
function mlrt.look_at(view)
    local function cross(a, b) return {a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1]} end
    local function unit(a, name)
        local length = math.sqrt(a[1] ^ 2 + a[2] ^ 2 + a[3] ^ 2)
        if not (length > 0 and length < math.huge) then error(name .. ": the vector is zero or not finite", 0) end
        return {a[1] / length, a[2] / length, a[3] / length}
    end
    local eye, target, fov = view.eye, view.target, view.fov or 45
    if not (fov > 0 and fov < 180) then error("fov: between 0 and 180 degrees, not " .. fov, 0) end
    local forward = unit({target[1] - eye[1], target[2] - eye[2], target[3] - eye[3]}, "target - eye")
    local right = unit(cross(forward, view.up or {0, 1, 0}), "up, seen along target - eye")
    local upward, pixel = cross(right, forward), 2 * math.tan(math.rad(fov) / 2) / view.height
    local camera = {width = view.width, height = view.height, eye = eye, d00 = {}, dx = {}, dy = {}}
    for k = 1, 3 do
        camera.d00[k] = forward[k] + pixel * (upward[k] * view.height - right[k] * view.width) / 2
        camera.dx[k], camera.dy[k] = right[k] * pixel, -upward[k] * pixel
    end
    return camera
end

--- The rays of a camera's pixels, row by row: tracing them gives what `tree:render` gives.
-- @param camera as in `tree:render`
-- @return rays: origins, directions, row_length
function mlrt.camera_rays(camera)
    local s, columns, rows = camera_struct(camera)
    local rays = {row_length = columns}
    local arrays = {}
    for _, name in ipairs{"origins", "directions"} do
        rays[name] = new_array("float", 3 * columns * rows, name)
        arrays[name] = ffi.new "mlrt_array"
        arrays[name].data = rays[name]
    end
    check(C.mlrt_camera_rays(s, arrays.origins, arrays.directions))
    keep(rays)
    return rays
end

--- A picture, row by row.
-- @param camera a table: width, height, eye, d00, dx, dy (three numbers each), crop = {x =, y =, width =, height =},
--   sample = {0.5, 0.5}, t_min, t_max, or projection = "parallel" with direction in place of eye. See `mlrt.look_at`
-- @param options as in `tree:trace`, and query ("closest", "any"); lights = a list of up to 8, `{kind =, position =}`, kind
--   "point" or "directional": bit k of occluded is 1 if light k does not reach the hit; on_tile = function(tile), which
--   receives an mlrt_tile, valid until it returns, and may return false to stop (not with a pool); tile_outputs = a list of
--   what tiles have: "t", "uv", "ids", "facing", "triangle", "occluded". With on_tile no frame is written, but to `into`
-- @return a table like that of `tree:trace`, with occluded
function Tree:render(camera, options)
    options = options or {}
    local query = choose(queries, options.query or "closest", "options.query")
    local view, columns, rows = camera_struct(camera)
    local lights = options.lights or {}
    local list = ffi.new("mlrt_light[?]", #lights)
    for i, light in ipairs(lights) do write_light(list[i - 1], light, "lights[" .. i - 1 .. "]") end
    local allowed = query == queries.any and {"occluded"} or closest
    if #lights > 0 and query == queries.closest then allowed = {"t", "u", "v", "mesh", "triangle", "facing", "occluded"} end
    local frame, arrays = nil, {}
    if not options.on_tile or options.into then
        frame = struct "hits"
        arrays = results(frame, options, allowed, function() return columns, rows end, {})
    end
    local settings, handle = trace_options(options, query), open(self)
    if #lights > 0 then settings.lights, settings.light_count = list, #lights end
    for _, name in ipairs(options.tile_outputs or {}) do
        settings.outputs = bit.bor(settings.outputs, choose(tile_outputs, name, "options.tile_outputs"))
    end
    local calls = callbacks(options)
    settings.host = calls.host
    local used = {self, options.pool}
    local status = call(calls, used, C.mlrt_render_tiles, handle, view, settings, frame, calls.tile, nil)
    keep(options, arrays, list)
    calls.finish(status)
    arrays.count = columns * rows
    return arrays
end

--- Which points are in the shadow of a light.
-- @param points a table: positions (three floats each), skip (mesh and triangle that a point lies on), row_length, count
-- @param light a table: kind ("point" or "directional"), position
-- @param options as in `tree:trace`
-- @return an array: 1 for each point that the light does not reach, else 0
function Tree:occluded_points(points, light, options)
    options = options or {}
    local kept, s, lamp, target = {places = {}}, struct "points", ffi.new "mlrt_light", ffi.new "mlrt_hits"
    local count = points.count or count_of(points.positions, 3) or error("points.count: it is needed", 0)
    count = whole(count, SIZE, "points.count")
    s.count, s.row_length = count, whole(points.row_length, WORD, "points.row_length")
    input(s.positions, points.positions, "float", 3, count, "points.positions", kept)
    input(s.skip, points.skip, "uint32_t", 2, count, "points.skip", kept)
    write_light(lamp, light, "light")
    local arrays = results(target, options, {"occluded"}, function() return count, 1 end, kept.places)
    local settings, handle = trace_options(options, queries.closest), open(self)
    local calls = callbacks(options)
    settings.host = calls.host
    local status = call(calls, {self, options.pool}, C.mlrt_occluded_points, handle, s, lamp, settings, target.occluded)
    keep(options, kept, arrays)
    calls.finish(status)
    return arrays.occluded
end

-- ---- single rays ---------------------------------------------------------------------------------------------------

-- The mesh and the triangle of a hit, or of what a ray skips.
local function number_of(hit, name)
    local function word(field)
        return whole(hit[field] or error(name .. "." .. field .. ": a number is needed", 0), WORD, name .. "." .. field)
    end
    return word "mesh", word "triangle"
end

local function ray_struct(ray)
    local s = struct "ray"
    vector(s.origin, ray.origin, "ray.origin")
    vector(s.direction, ray.direction, "ray.direction")
    s.t_min, s.t_max = ray.t_min or 0, ray.t_max or 0
    if ray.skip then s.flags, s.skip_mesh, s.skip_triangle = 1, number_of(ray.skip, "ray.skip") end
    return s
end

local function trace_one(tree, ray, options, query)
    options = options or {}
    local hit = struct "hit"
    check(C.mlrt_trace_ray(open(tree), ray_struct(ray), trace_options(options, query), hit))
    keep(options)
    return hit
end

--- The closest hit of one ray. For more than a few, `tree:trace` is many times faster per ray.
-- @param ray a table: origin, direction, t_min, t_max (0 or nil = no limit), skip = {mesh =, triangle =}
-- @param options as in `tree:trace`
-- @return an mlrt_hit: t, u, v, mesh, triangle, facing. A miss has mesh = NONE
function Tree:trace_ray(ray, options)
    return trace_one(self, ray, options, queries.closest)
end

--- Whether one ray hits anything.
-- @return true or false
function Tree:occluded_ray(ray, options)
    return trace_one(self, ray, options, queries.any).occluded == 1
end

--- The ray that decides whether a light reaches the hit of a ray.
-- @param ray a ray, as in `tree:trace_ray`
-- @param hit its hit: mesh and triangle are read
-- @param light as in `tree:occluded_points`
-- @return a ray; nil if the light is on the other side
function Tree:shadow_ray(ray, hit, light)
    local found, lamp, s, faces = struct "hit", ffi.new "mlrt_light", struct "ray", ffi.new "int32_t[1]"
    found.mesh, found.triangle = number_of(hit, "hit")
    write_light(lamp, light, "light")
    check(C.mlrt_shadow_ray(open(self), ray_struct(ray), found, lamp, s, faces))
    if faces[0] == 0 then return nil end
    return {
        origin = {s.origin[0], s.origin[1], s.origin[2]}, direction = {s.direction[0], s.direction[1], s.direction[2]},
        t_min = s.t_min, t_max = s.t_max, skip = s.flags % 2 == 1 and {mesh = s.skip_mesh, triangle = s.skip_triangle} or nil,
    }
end

--- A point just off a hit, strictly on one side.
-- @param hit mesh, triangle, u and v are read
-- @param side +1: the side to which the normal points; -1: the other one; -hit.facing: that from which the ray came
-- @return three numbers, in a table
function Tree:offset_point(hit, side)
    local point = ffi.new "float[3]"
    local mesh, triangle = number_of(hit, "hit")
    if side ~= 1 and side ~= -1 then error("side: " .. tostring(side) .. " is not 1 or -1", 0) end
    check(C.mlrt_offset_point(open(self), mesh, triangle, hit.u, hit.v, side, point))
    return {point[0], point[1], point[2]}
end

-- ---- without a tree ------------------------------------------------------------------------------------------------

--- Counts of the work of tracing, to which calls with options.counters add: its fields are those of mlrt_counters.
-- @return an object: `counters.ray_count` is a number
function mlrt.counters()
    local counts = struct "counters"
    return setmetatable({struct = counts}, {__index = function(_, name) return tonumber(counts[name]) end})
end

--- The library's version.
-- @return a string, as "0.1.0"
function mlrt.version()
    local number = C.mlrt_version()
    return math.floor(number / 10000) .. "." .. math.floor(number / 100) % 100 .. "." .. number % 100
end

--- The instruction sets that the library has and this machine can run.
-- @return a table: sse, avx2, avx512, neon, each true or false
function mlrt.capabilities()
    local bits = tonumber(C.mlrt_capabilities())
    return {sse = bits % 2 >= 1, avx2 = bits % 4 >= 2, avx512 = bits % 8 >= 4, neon = bits % 16 >= 8}
end

return mlrt

-- SPDX-License-Identifier: MIT
-- The scene of bindings/c/scene.h: prints the hash of the answers, and tests each part of the interface; with the argument
-- `hash` prints the hash alone.

local ffi, bit, mlrt = require "ffi", require "bit", require "mlrt"

local state = 1
local function draw()
    state = (state * 1664525 + 1013904223) % 2^32 -- exact: below 2^53
    return math.floor(state / 2^20)
end
local function coordinates(array, first, count, divisor)
    for i = first, first + count - 1 do array[i] = (draw() - 2048) / divisor end
    return array
end

local COUNT = 1000
local meshes = {}
for m, id in ipairs{7, 3} do
    meshes[m] = {id = id, vertices = coordinates(ffi.new "float[300]", 0, 300, 256), indices = ffi.new "uint32_t[450]"}
    for i = 0, 449 do meshes[m].indices[i] = draw() % 100 end
end
local origins, directions = ffi.new "float[3000]", ffi.new "float[3000]"
for i = 0, COUNT - 1 do
    coordinates(origins, 3 * i, 3, 256)
    coordinates(directions, 3 * i, 3, 2048)
    for k = 0, i % 4 == 3 and 2 or -1 do
        directions[3 * i + k] = meshes[1].vertices[3 * (i % 100) + k] - origins[3 * i + k]
    end
end
local rays = {origins = origins, directions = directions}

local function hash(hits)
    local sum, word, bytes = 0xCBF29CE484222325ULL, ffi.new "uint32_t[1]", nil
    bytes = ffi.cast("const uint8_t *", word)
    for i = 0, hits.count - 1 do
        for _, name in ipairs{"t", "u", "v", "mesh", "triangle", "facing"} do
            ffi.copy(word, hits[name] + i, 4)
            for b = 0, 3 do sum = bit.bxor(sum, bytes[b]) * 0x100000001B3ULL end
        end
    end
    return bit.tohex(sum)
end

-- The error of a call, whose text must match, or whose status must be the one named.
local function fails(expected, f, ...)
    local ok, problem = pcall(f, ...)
    assert(not ok, "no such error: " .. expected)
    local status = mlrt.STATUS[expected]
    assert(status and problem.status == status and problem.message ~= "" or tostring(problem):find(expected),
        "expected " .. expected .. ", but: " .. tostring(problem))
    return problem
end

local tree, pool = mlrt.build(meshes), mlrt.pool(2)
local hits = tree:trace(rays)
local golden = hash(hits)
local corners = {0, 0, 5, 1, 0, 5, 0, 1, 5}
local one = mlrt.build{vertices = corners, indices = {0, 1, 2}}
local down = {origin = {0.25, 0.25, 0}, direction = {0, 0, 1}}
local large = {vertices = coordinates(ffi.new "float[900000]", 0, 900000, 64)} -- takes a while to build
local camera = mlrt.look_at{eye = {0, 0, -30}, target = {0, 0, 0}, width = 40, height = 30}

local tests = {}

function tests.builders()
    for _, same in ipairs{
        mlrt.build(meshes, {preset = "fast", traversal_cost = 2}), mlrt.build(meshes, {preset = "best", pool = pool}),
        mlrt.build_kdtree(meshes, {preset = "tuned", max_depth = 3, max_references = 1e5, rules_off = mlrt.RULE.RETRACTION}),
    } do
        assert(hash(same:trace(rays)) == golden)
        same:close()
    end
    local info, kdtree = tree:info(), mlrt.build_kdtree(meshes, {max_depth = 3}):info()
    assert(info.structure == "bvh" and info.triangle_count == 300 and info.memory_size > 300 * 36 and info.bounds_min[1] < info.bounds_max[1])
    assert(kdtree.structure == "kdtree" and kdtree.depth <= 3)
    assert(mlrt.estimate_tree(meshes).memory_size > 0 and mlrt.estimate_kdtree(meshes).peak_memory_size > 0)
    fails("OUT_OF_MEMORY", mlrt.build, meshes, {memory_limit = 1000})
    fails("there is no quick", mlrt.build, meshes, {preset = "quick"})
end

function tests.every_option_together()
    local lines = 0
    local function log() lines = lines + 1 end
    local function go_on() return true end
    local boxes = mlrt.build(meshes, {
        preset = "best", traversal_cost = 2, intersection_cost = 0.5, memory_limit = 2 ^ 30, pool = mlrt.pool(1), log = log, progress = go_on,
    })
    local kdtree = mlrt.build_kdtree(meshes, {
        preset = "tuned", traversal_cost = 2, intersection_cost = 0.5, memory_limit = 2 ^ 30, max_references = 1e6, max_depth = 20,
        rules_off = mlrt.RULE.COPLANAR, pool = mlrt.pool(1), log = log, progress = go_on,
    })
    local loaded = mlrt.load(boxes:save(), {memory_limit = 2 ^ 30, log = log})
    for _, same in ipairs{boxes, kdtree, loaded} do
        assert(hash(same:trace(rays)) == golden)
        same:close()
    end
    assert(lines >= 2)
    fails("ARGUMENT", mlrt.build, meshes, {traversal_cost = -1})
end

function tests.layouts_of_meshes()
    local mesh = {vertices = meshes[1].vertices, indices = meshes[1].indices}
    local wide, narrow, plain = ffi.new "float[500]", ffi.new "uint16_t[600]", ffi.new "float[1350]"
    for i = 0, 99 do ffi.copy(wide + 5 * i, mesh.vertices + 3 * i, 12) end
    for i = 0, 449 do
        narrow[math.floor(i / 3) * 4 + i % 3] = mesh.indices[i]
        ffi.copy(plain + 3 * i, mesh.vertices + 3 * mesh.indices[i], 12)
    end
    local expected = hash(mlrt.build(mesh):trace(rays))
    for _, same in ipairs{{vertices = wide, vertex_stride = 20, indices = narrow, triangle_stride = 8}, {vertices = plain}} do
        assert(mlrt.hash_geometry(same) == mlrt.hash_geometry(mesh))
        assert(hash(mlrt.build(same):trace(rays)) == expected)
    end
end

function tests.callbacks()
    local last, calls, lines = -1, 0, {}
    mlrt.build(large, {
        progress = function(fraction) assert(fraction >= last) last, calls = fraction, calls + 1 end,
        log = function(level, line) lines[#lines + 1] = level .. line end,
    }):close()
    assert(last == 1 and calls > 0 and table.concat(lines):find "^info")
    fails("CANCELLED", mlrt.build, large, {progress = function() return false end})
    fails("enough", mlrt.build, large, {progress = function() error "enough" end})
    fails("enough", mlrt.build, large, {log = function() error "enough" end})
    fails("with a pool", mlrt.build, large, {pool = pool, progress = print})
    local many = ffi.new "float[3000000]"
    for i = 0, 2999999 do many[i] = directions[i % 3000] end
    fails("CANCELLED", tree.trace, tree, {origins = mlrt.all{0, 0, 0}, directions = many}, {method = "ray", progress = function() return false end})
end

function tests.saving()
    local data = tree:save()
    local room = ffi.new("uint8_t[?]", #data + 64)
    local aligned = room + (64 - tonumber(ffi.cast("uintptr_t", room) % 64)) % 64
    ffi.copy(aligned, data, #data)
    local in_place = mlrt.load(aligned, {in_place = true, size = #data})
    assert(in_place:info().memory_size < #data)
    for _, same in ipairs{mlrt.load(data, {geometry_hash = mlrt.hash_geometry(meshes)}), in_place} do
        assert(hash(same:trace(rays)) == golden and same:info().tree_hash == tree:info().tree_hash)
        same:close()
    end
    room[0] = 0 -- the tree needed it until now
    fails("options.size", mlrt.load, aligned)
    fails("DATA", mlrt.load, data, {geometry_hash = 1})
    fails("DATA", mlrt.load, data:sub(1, -2) .. string.char((data:byte(-1) + 1) % 256))
end

function tests.options()
    local paper = {
        method = "multilevel", culling = "direct", culling_check = true, initial_tile_size = 64, minimum_tile_size = 8, split_factor = 4,
        shortcuts_off = mlrt.SHORTCUT.WHOLE_TILES,
    }
    local can = mlrt.capabilities()
    local narrowest = can.sse and "sse" or can.neon and "neon" or "scalar"
    for _, options in ipairs{{method = "ray"}, {method = "tile", isa = narrowest}, {pool = pool}} do
        assert(hash(tree:trace(rays, options)) == golden)
    end
    assert(hash(mlrt.build_kdtree(meshes):trace(rays, paper)) == golden)
    fails("UNSUPPORTED", tree.trace, tree, rays, paper)
    fails("ARGUMENT", tree.trace, tree, rays, {initial_tile_size = 5})
    local counters = mlrt.counters()
    tree:trace(rays, {counters = counters})
    tree:trace(rays, {counters = counters})
    assert(counters.ray_count == 2 * COUNT and counters.triangle_test_count > 0)
end

function tests.arrays()
    local occluded = tree:occluded(rays, {pool = pool})
    for i = 0, COUNT - 1 do assert((occluded[i] == 1) == (hits.mesh[i] ~= mlrt.NONE)) end
    local both, zeros, written = ffi.new "float[6000]", ffi.new "float[3000]", ffi.new "float[3000]"
    for i = 0, COUNT - 1 do
        ffi.copy(both + 6 * i, origins + 3 * i, 12)
        ffi.copy(both + 6 * i + 3, directions + 3 * i, 12)
        ffi.copy(written + 3 * i, origins + 3 * math.floor(i / 5), 12)
    end
    local strided = {origins = {data = both, stride = 24}, directions = {data = both + 3, stride = 24}}
    fails("rays.count", tree.trace, tree, strided)
    strided.count = COUNT
    assert(hash(tree:trace(strided)) == golden)
    strided.count = COUNT + 1
    fails("too few", tree.trace, tree, strided)
    assert(hash(tree:trace{origins = mlrt.all{0, 0, 0}, directions = directions}) == hash(tree:trace{origins = zeros, directions = directions}))
    local fan = ffi.new "float[600]"
    ffi.copy(fan, origins, 2400)
    assert(hash(tree:trace{origins = fan, directions = directions, rays_per_origin = 5}) == hash(tree:trace{origins = written, directions = directions}))
    local records = ffi.new "float[2000]"
    local wanted = tree:trace(rays, {into = {t = {data = records, stride = 8}}})
    for i = 0, COUNT - 1 do assert(records[2 * i] == hits.t[i] and records[2 * i + 1] == 0) end
    assert(wanted.u == nil and tree:trace(rays, {outputs = {"triangle"}}).t == nil)
    fails("outputs: occluded", tree.trace, tree, rays, {outputs = {"occluded"}})
    fails("into.t", tree.trace, tree, rays, {into = {t = ffi.new "float[999]"}})
    fails("2997 numbers, but 3000", tree.trace, tree, {origins = ffi.new "float[2997]", directions = directions})
    fails("float", tree.trace, tree, {origins = ffi.new "double[1500]", directions = directions})
end

function tests.ranges_skips_masks()
    local limits, skip, mask = ffi.new "float[1000]", ffi.new "uint32_t[2000]", ffi.new "uint32_t[1000]"
    for i = 0, COUNT - 1 do
        limits[i] = hits.t[i] * (i % 2 == 0 and 0.999 or 1.001)
        skip[2 * i], skip[2 * i + 1], mask[i] = hits.mesh[i], hits.triangle[i], 1 + i % 2
    end
    local near = tree:trace{origins = origins, directions = directions, t_min = 0, t_max = limits}
    local behind, farther = tree:trace{origins = origins, directions = directions, skip = skip}, 0
    local masked = mlrt.build{
        {id = 7, mask = 1, vertices = meshes[1].vertices, indices = meshes[1].indices},
        {id = 3, mask = 2, vertices = meshes[2].vertices, indices = meshes[2].indices},
    }
    local all, each = masked:trace(rays, {mask = 2}), masked:trace{origins = origins, directions = directions, mask = mask}
    for i = 0, COUNT - 1 do
        assert(near.mesh[i] == (i % 2 == 0 and mlrt.NONE or hits.mesh[i]))
        assert(behind.t[i] >= hits.t[i])
        if behind.t[i] > hits.t[i] then farther = farther + 1 end
        assert(all.mesh[i] == mlrt.NONE or all.mesh[i] == 3)
        assert(each.mesh[i] == mlrt.NONE or each.mesh[i] == (i % 2 == 0 and 7 or 3))
    end
    assert(farther > 0)
end

function tests.single_rays()
    local hit = one:trace_ray(down)
    assert(hit.t == 5 and hit.u == 0.25 and hit.v == 0.25 and hit.mesh == 0 and hit.triangle == 0 and hit.facing == 1)
    assert(one:trace_ray{origin = down.origin, direction = down.direction, t_max = 4}.mesh == mlrt.NONE)
    assert(one:trace_ray{origin = down.origin, direction = down.direction, t_min = 5}.mesh == mlrt.NONE)
    assert(not one:occluded_ray{origin = down.origin, direction = down.direction, skip = hit} and one:occluded_ray(down))
    for i = 0, 49 do
        local same = tree:trace_ray{origin = origins + 3 * i, direction = directions + 3 * i}
        assert(same.t == hits.t[i] and same.triangle == hits.triangle[i])
    end
    fails("UNSUPPORTED", one.trace_ray, one, down, {method = "multilevel"})
    local point = one:offset_point(hit, -hit.facing)
    assert(point[3] < 5 and point[3] > 4.99)
    fails("ARGUMENT", one.offset_point, one, {mesh = 0, triangle = 1, u = 0, v = 0}, 1)
    local positions, light = {point[1], point[2], point[3], 0.25, 0.25, 6}, {position = {0.25, 0.25, 0}}
    local dark = one:occluded_points({positions = positions}, light, {pool = pool})
    assert(dark[0] == 0 and dark[1] == 1)
    dark = one:occluded_points({positions = positions, skip = mlrt.all{0, 0}, row_length = 2}, light)
    assert(dark[0] == 0 and dark[1] == 0)
    dark = one:occluded_points({positions = positions}, {kind = "directional", position = {0, 0, 1}})
    assert(dark[0] == 1 and dark[1] == 0)
end

function tests.all_hits()
    local lists, totals = tree:all_hits(rays, {capacity = 4, pool = pool}), tree:all_hits(rays)
    for i = 0, COUNT - 1 do
        assert(lists.t[4 * i] == hits.t[i] and lists.triangle[4 * i] == hits.triangle[i] and lists.mesh[4 * i] == hits.mesh[i])
        assert(lists.total[i] == totals.total[i] and lists.crossing_total[i] <= lists.total[i])
    end
    assert(totals.t == nil)
end

function tests.pictures()
    local lights = {{position = {0, 10, -30}}, {kind = "directional", position = {0, 1, -1}}}
    local frame, written = tree:render(camera, {lights = lights, pool = pool}), mlrt.camera_rays(camera)
    local traced, any = tree:trace(written), tree:render(camera, {query = "any"})
    local lit = 0
    for i = 0, 1199 do
        assert(frame.t[i] == traced.t[i] and frame.triangle[i] == traced.triangle[i])
        assert((any.occluded[i] == 1) == (frame.mesh[i] ~= mlrt.NONE))
        for k, light in ipairs(frame.mesh[i] ~= mlrt.NONE and lights or {}) do
            local ray = {origin = written.origins + 3 * i, direction = written.directions + 3 * i}
            local shadow = tree:shadow_ray(ray, {mesh = frame.mesh[i], triangle = frame.triangle[i]}, light)
            local dark = shadow == nil or tree:occluded_ray(shadow)
            assert((math.floor(frame.occluded[i] / 2 ^ (k - 1)) % 2 == 1) == dark)
            if not dark then lit = lit + 1 end
        end
    end
    assert(lit > 0)
    fails("ARGUMENT", tree.shadow_ray, tree, down, {mesh = 99, triangle = 0}, lights[1])

    camera.crop = {x = 8, y = 4, width = 16, height = 12}
    local part, wide = tree:render(camera), ffi.new "float[1200]" -- rows of a larger picture
    tree:render(camera, {into = {t = {data = wide, row_stride = 400}}})
    camera.crop = nil
    for i = 0, 191 do
        assert(part.t[i] == frame.t[(4 + math.floor(i / 16)) * 40 + 8 + i % 16])
        assert(part.t[i] == wide[100 * math.floor(i / 16) + i % 16])
    end
    local flat = {projection = "parallel", width = 4, height = 4, direction = {0, 0, 1}, d00 = {-1, -1, 0}, dx = {0.5, 0, 0}, dy = {0, 0.5, 0}}
    assert(one:render(flat).t[2 * 4 + 2] == 5)
    flat.t_max = 4
    assert(one:render(flat).facing[10] == 0)
    flat.t_min, flat.t_max = 5, 0
    assert(one:render(flat).facing[10] == 0)
    fails("CAMERA", tree.render, tree, {width = 0, height = 0})

    local triangles, dark = ffi.new "uint32_t[1200]", ffi.new "uint8_t[1200]"
    local options = {lights = lights, tile_outputs = {"triangle", "occluded"}, initial_tile_size = 16}
    function options.on_tile(tile)
        assert(tile.t == nil)
        for j = 0, tile.height - 1 do
            ffi.copy(triangles + (tile.y + j) * 40 + tile.x, tile.triangle + j * tile.width, 4 * tile.width)
            ffi.copy(dark + (tile.y + j) * 40 + tile.x, tile.occluded + j * tile.width, tile.width)
        end
    end
    tree:render(camera, options)
    for i = 0, 1199 do assert(triangles[i] == frame.triangle[i] and dark[i] == frame.occluded[i]) end
    options.on_tile = function() return false end
    fails("CANCELLED", tree.render, tree, camera, options)
    options.on_tile = function() error "enough" end
    fails("enough", tree.render, tree, camera, options)
end

function tests.errors()
    local problem = fails("triangle 1: vertex index 3", mlrt.build, {vertices = corners, indices = {0, 1, 2, 0, 1, 3}})
    assert(problem.status == mlrt.STATUS.INDEX_RANGE)
    fails("ARGUMENT", mlrt.pool, 5000)
    fails("float", mlrt.build, {vertices = ffi.new "double[9]", indices = {0, 1, 2}})
    fails("float", mlrt.build, {vertices = ffi.new "float[10]"})
    assert(mlrt.version():find "^%d+%.%d+%.%d+$" and type(mlrt.capabilities().avx2) == "boolean" and mlrt.status_string(3) ~= "")
    local empty = mlrt.build{}
    assert(empty:trace{origins = {0, 0, 0}, directions = {0, 0, 1}}.mesh[0] == mlrt.NONE)
end

function tests.threads_of_a_pool()
    assert(mlrt.pool():threads() >= 1 and mlrt.pool(0):threads() >= 1)
    assert(mlrt.pool(1):threads() == 1 and mlrt.pool(2):threads() == 2)
    local closed = mlrt.pool(2)
    closed:close()
    fails("after close", closed.threads, closed)
    fails("after close", tree.trace, tree, rays, {pool = closed, progress = print})
end

-- What C would take for another number, or read and write behind arrays.
function tests.numbers_that_are_none()
    local far = {data = ffi.new "float[3]", stride = 12}
    for _, count in ipairs{-1, 1.5, 0 / 0, 2^53 + 2, 1 / 0} do
        fails("rays.count: .* is not a whole number", tree.trace, tree, {count = count, origins = far, directions = far})
        fails("count: .* is not a whole number", mlrt.build, {vertices = corners, vertex_count = count})
        fails("count: .* is not a whole number", mlrt.build, {vertices = corners, indices = {0, 1, 2}, triangle_count = count})
        fails("points.count: .* is not", tree.occluded_points, tree, {count = count, positions = far}, {position = {0, 0, 0}})
    end
    for _, word in ipairs{-1, 0.5, 2^32} do
        fails("rays_per_origin", tree.trace, tree, {origins = origins, directions = directions, rays_per_origin = word})
        fails("row_length", tree.trace, tree, {origins = origins, directions = directions, row_length = word})
        fails("capacity", tree.all_hits, tree, rays, {capacity = word})
        fails("split_factor", tree.trace, tree, rays, {split_factor = word})
        fails("camera.width", tree.render, tree, {width = word, height = 1})
        fails("threads", mlrt.pool, word)
        fails("ray.skip.mesh", one.trace_ray, one, {origin = {0, 0, 0}, direction = {0, 0, 1}, skip = {mesh = word, triangle = 0}})
    end
    fails("stride", tree.trace, tree, {count = 2, origins = {data = far.data, stride = -12}, directions = far})
    fails("stride", tree.trace, tree, rays, {into = {t = {data = ffi.new "float[1]", stride = -4}}})
    fails("options.mask", tree.trace, tree, rays, {mask = 2^32})
    assert(one:trace({origins = {0.25, 0.25, 0}, directions = {0, 0, 1}}, {mask = bit.bnot(0)}).mesh[0] == 0)
    fails("three numbers", one.trace_ray, one, {origin = ffi.new "float[2]", direction = {0, 0, 1}})
    fails("three numbers", one.trace_ray, one, {origin = ffi.new "double[2]", direction = {0, 0, 1}})
    fails("options.size: 9 bytes, but data has 8", mlrt.load, ("x"):rep(8), {size = 9})
    fails("options.size", mlrt.load, ("x"):rep(8), {size = -1})
    fails("a pointer", mlrt.load, 64, {size = 64})
end

function tests.nothing_is_closed_during_its_call()
    local own, threads = mlrt.build(meshes), mlrt.pool(1)
    local view = mlrt.look_at{eye = {0, 0, -30}, target = {0, 0, 0}, width = 64, height = 64}
    fails("closed during a call", own.render, own, view, {on_tile = function() own:close() end})
    fails("closed during a call", own.render, own, view, {pool = threads, on_tile = function() threads:close() end})
    assert(own:render(view, {pool = threads}).count == 64 * 64)
    threads:close()
    own:close()
end

-- There are some hundred callbacks at a time, and a call that fails keeps none of them.
function tests.callbacks_of_calls_that_fail()
    for _ = 1, 2000 do
        fails("options.isa", tree.trace, tree, rays, {isa = "none", progress = print})
        fails("options.preset", mlrt.build, meshes, {preset = "none", progress = print})
        fails("options.size", mlrt.load, "x", {size = 2, log = print})
        fails("mlrt_pool", tree.trace, pool, rays, {progress = print})
    end
    local others, free = {}, true
    while free do
        free, others[#others + 1] = pcall(ffi.cast, "mlrt_log_callback", function() end)
    end
    table.remove(others) -- the error
    table.remove(others):free()
    for _ = 1, 2 do fails("too many callbacks", tree.trace, tree, rays, {progress = print, log = print}) end
    tree:trace(rays, {progress = function() end})
    for _, other in ipairs(others) do other:free() end
end

-- ffi.cast takes any number, and any string, for an address.
function tests.memory_that_is_none()
    for _, data in ipairs{8, 16LL, "four", {1, 2, 3}, true} do
        local strided = {data = data, stride = 12}
        fails("rays.origins: data: an FFI", one.trace, one, {origins = strided, directions = {0, 0, 1}, count = 1})
        fails("into.t: data: an FFI array", one.trace, one, rays, {into = {t = {data = data}}})
    end
    local text = ("x"):rep(4 * COUNT)
    for _, into in ipairs{8, text, true, ffi.new "const float[1000]", ffi.new "double[1000]"} do
        fails("into.t: float%[%] is needed", tree.trace, tree, rays, {into = {t = into}})
    end
    assert(text == ("x"):rep(4 * COUNT))
    fails("into.t: data", tree.trace, tree, rays, {outputs = {"u"}, into = {t = {data = ffi.cast("float *", 0)}}})
    fails("into.t: data", tree.trace, tree, rays, {outputs = {"u"}, into = {t = {0, 0, 0}}})
    fails("a pointer and options.size", mlrt.load, 64LL, {size = 64})
    fails("a pointer and options.size", mlrt.load, ffi.new "struct {char bytes[8];}", {size = 64})
    fails("mlrt.counters%(%) is needed", tree.trace, tree, rays, {counters = {}})
end

function tests.tables_are_copied_exactly()
    for _, index in ipairs{1.5, -1, 2^32 + 1, 0 / 0} do
        local skipping = {origins = {0, 0, 0}, directions = {0, 0, 1}, skip = {index, 0}}
        fails("indices: .* is not a whole number", mlrt.build, {vertices = corners, indices = {0, index, 2}})
        fails("rays.skip: .* is not a whole number", one.trace, one, skipping)
    end
    for _, none in ipairs{"1", true} do
        fails("rays.origins: a number is needed", one.trace, one, {origins = {0, none, 0}, directions = {0, 0, 1}})
        local all = mlrt.all{0, none, 0}
        fails("rays.origins: a number is needed", one.trace, one, {origins = all, directions = {0, 0, 1}})
        fails("ray.origin: a number is needed", one.trace_ray, one, {origin = {0, none, 0}, direction = {0, 0, 1}})
    end
    local hole = {0, 0, nil, 0, 0, 0}
    fails("a number is needed, not nil", one.trace, one, {origins = hole, directions = {0, 0, 1, 0, 0, 1}})
    assert(one:trace{origins = {[0] = 9, 0.25, 0.25, 0}, directions = {0, 0, 1}}.mesh[0] == 0)
    assert(one:trace{origins = {0.25, 0.25, 0}, directions = {0, 0, 1}, mask = {bit.bnot(0)}}.mesh[0] == 0)
    fails("mlrt.all: a table", mlrt.all, 3)
end

function tests.results_that_share_memory()
    local room = ffi.new "float[7000]"
    local function part(first, stride) return {data = room + first, stride = stride} end
    local both = {origins = part(0, 24), directions = part(3, 24), count = COUNT}
    for _, into in ipairs{
        {t = part(0), u = part(999)}, {t = part(0), mesh = part(0)}, {t = part(0, 24), mesh = part(6, 24)},
        {t = part(1, 8), u = part(0)},
    } do
        fails("shares memory", tree.trace, tree, rays, {into = into})
    end
    fails("shares memory with rays", tree.trace, tree, both, {into = {t = part(5, 24)}})
    fails("shares memory with rays", tree.trace, tree, rays, {into = {t = {data = origins}}})
    fails("shares memory", tree.all_hits, tree, rays, {into = {total = part(9), crossing_total = part(0)}})
    local function row(first) return {data = room + first, row_stride = 320} end
    fails("shares memory", tree.render, tree, camera, {into = {t = row(0), u = row(39)}})

    -- Records, halves and rows in turn do not.
    tree:trace(rays, {into = {t = part(0, 24), mesh = part(1, 24), u = part(3, 24)}})
    for i = 0, COUNT - 1 do assert(room[6 * i] == hits.t[i] and room[6 * i + 3] == hits.u[i]) end
    tree:trace(rays, {into = {t = part(0), u = part(1000)}})
    tree:render(camera, {into = {t = row(0), u = row(40)}})
end

function tests.vectors_that_are_needed()
    fails("ray.origin: three numbers", one.trace_ray, one, {direction = {0, 0, 1}})
    fails("ray.direction: three numbers", one.trace_ray, one, {origin = {0, 0, 0}})
    fails("ray.origin: three numbers", one.trace_ray, one, {origin = ffi.new "int64_t[2]", direction = {0, 0, 1}})
    fails("light.position: three numbers", one.occluded_points, one, {positions = {0, 0, 0}}, {})
    for _, side in ipairs{0.5, 1.5, 2^32 + 1, 0 / 0, "x"} do
        fails("side: .* is not 1 or %-1", one.offset_point, one, {mesh = 0, triangle = 0, u = 0, v = 0}, side)
    end
    for _, wrong in ipairs{-1, 0.5, 0 / 0, 2^64, true} do
        fails("geometry_hash", mlrt.load, tree:save(), {geometry_hash = wrong})
    end
    local wide = {width = 65536, height = 65536}
    fails("more than an FFI array can have", mlrt.camera_rays, wide)
    fails("more than an FFI array can have", one.render, one, wide)
end

local names = {}
for name in pairs(arg[1] == "hash" and {} or tests) do names[#names + 1] = name end
table.sort(names)
for _, name in ipairs(names) do
    local ok, problem = pcall(tests[name])
    if not ok then error(name .. ": " .. tostring(problem)) end
end

pool:close()
fails("after close", tree.trace, tree, rays, {pool = pool})
tree:close()
tree:close()
fails("after close", tree.trace, tree, rays)
tree, pool, one = nil, nil, nil
collectgarbage()

print(golden)

-- For a C compiler to look at.
local file = assert(package.searchpath("mlrt", package.path))
for name, fields in io.open(file):read("*a"):gmatch "typedef struct (mlrt_[%w_]+) {(.-)} mlrt_" do
    print("layout " .. name .. " sizeof " .. ffi.sizeof(name))
    for field in fields:gsub("%[%d+%]", ""):gmatch "([%w_]+)%s*[,;]" do print("layout " .. name .. " " .. field .. " " .. ffi.offsetof(name, field)) end
end

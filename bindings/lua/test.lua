-- SPDX-License-Identifier: MIT
-- The scene of bindings/c/scene.h: prints the hash of the answers, and checks errors and closing.

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

local meshes = {}
for m, id in ipairs{7, 3} do
    meshes[m] = {id = id, vertices = coordinates(ffi.new "float[300]", 0, 300, 256), indices = ffi.new "uint32_t[450]"}
    for i = 0, 449 do meshes[m].indices[i] = draw() % 100 end
end
local origins, directions = ffi.new "float[3000]", ffi.new "float[3000]"
for i = 0, 999 do
    coordinates(origins, 3 * i, 3, 256)
    coordinates(directions, 3 * i, 3, 2048)
    for k = 0, i % 4 == 3 and 2 or -1 do
        directions[3 * i + k] = meshes[1].vertices[3 * (i % 100) + k] - origins[3 * i + k]
    end
end

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

local function fails(pattern, f, ...)
    local ok, problem = pcall(f, ...)
    assert(not ok and tostring(problem):find(pattern), "no such error: " .. pattern .. ", but " .. tostring(problem))
    return problem
end

local tree, pool = mlrt.tree(unpack(meshes)), mlrt.pool(2)
local hits = tree:trace(origins, directions)
assert(hash(tree:trace(origins, directions, pool)) == hash(hits))
local occluded = tree:occluded(origins, directions, pool)
for i = 0, 999 do assert((occluded[i] == 1) == (hits.mesh[i] ~= mlrt.NONE)) end

local corners = {0, 0, 5, 1, 0, 5, 0, 1, 5}
local one = mlrt.tree{vertices = corners, indices = {0, 1, 2}}:trace({0.25, 0.25, 0}, {0, 0, 1})
assert(one.t[0] == 5 and one.triangle[0] == 0)
local problem = fails("triangle 1: vertex index 3", mlrt.tree, {vertices = corners, indices = {0, 1, 2, 0, 1, 3}})
assert(problem.status == 3)
assert(fails("invalid argument", mlrt.pool, 5000).status == 1)
fails("float", mlrt.tree, {vertices = ffi.new "double[9]", indices = {0, 1, 2}})
fails("as many", tree.trace, tree, {0, 0, 0}, {0, 0, 1, 0, 0, 1})

pool:close()
fails("after close", tree.trace, tree, origins, directions, pool)
tree:close()
tree:close()
fails("after close", tree.trace, tree, origins, directions)
tree, pool = nil, nil
collectgarbage()

print(hash(hits))

-- For a C compiler to look at.
for name, fields in io.open("mlrt.lua"):read("*a"):gmatch "typedef struct (mlrt_[%w_]+) {(.-)} mlrt_" do
    print("layout " .. name .. " sizeof " .. ffi.sizeof(name))
    for field in fields:gmatch "([%w_]+)%s*[,;]" do print("layout " .. name .. " " .. field .. " " .. ffi.offsetof(name, field)) end
end
